"""Scripts carried out in MuJoCo: the model of a context, driving, lifting and putting down."""
