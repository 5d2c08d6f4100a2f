"""Table 1: accuracy of predicted correspondences; the learning curve; lists of errors."""
