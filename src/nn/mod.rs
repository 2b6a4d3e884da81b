//! Network building blocks and weight files: the only place that names the machine-learning framework.
//! May not know rooms, bodies or files beyond the weights it is given. Enters with the learned samplers.
