"""``ct eval --end-to-end``: plans of held-out commands as videos that people rate (section 4.3).

A study is a folder. :mod:`~eval.plan_study.study_plans` makes plans,
:mod:`~eval.plan_study.filming` carries them out and films them, :mod:`~eval.plan_study.study_pairs`
writes what people are to rate, and
:mod:`~eval.plan_study.study_results` says what came of it. Each step goes on where it was stopped.
"""
