"""Statistics of rating studies: what people say of commands and videos, and how sure that is.

:mod:`~eval.studies.ratings` reads judgments; :mod:`~eval.studies.intervals` gives bounds of a
share; :mod:`~eval.studies.ordinal` looks at all five points; :mod:`~eval.studies.comparison`
compares configurations; :mod:`~eval.studies.raters` weighs raters; :mod:`~eval.studies.power`
plans; :mod:`~eval.studies.table_2` is Table 2 of the paper.
"""
