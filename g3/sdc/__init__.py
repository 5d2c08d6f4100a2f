"""Spatial description clauses: what a command is made of (section 3.1).

Read :mod:`~g3.sdc.clauses` first, then :mod:`~g3.sdc.sdc_notation` (clauses as text and JSON).
"""

from g3.sdc.clauses import SDC, SDC_TYPES, SDCType, breadth_first

__all__ = ["SDC", "SDC_TYPES", "SDCType", "breadth_first"]
