# The fast kernels are compiled once per instruction set (see src/lbm/kernels/cpu).
