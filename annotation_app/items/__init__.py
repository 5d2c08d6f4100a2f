"""Items that people work on: their assignment, their answers, and the scenes of their videos."""
