from hypothesis import settings

# The machine may be busy: how long one example takes says nothing.
# The checks try the same examples every time; `pytest --hypothesis-profile explore` tries others.
settings.register_profile("checks", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None, max_examples=1000)
settings.load_profile("checks")
