"""Table 1: how well a model predicts correspondences; the learning curve; lists of errors."""
