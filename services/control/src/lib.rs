//! Plants, controllers, discretisation, step metrics and stability margins
