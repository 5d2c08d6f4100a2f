"""``ct eval end-to-end``: plans of held-out commands as videos that people rate (section 4.3).

A study is a folder. :mod:`~eval.plan_study.study_plans` makes plans and carries them out,
:mod:`~eval.plan_study.study_plans` films them and writes the pairs to rate, and
:mod:`~eval.plan_study.whole_study` reports the results. Each step resumes where it was stopped.
"""
