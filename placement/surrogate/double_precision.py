"""JAX in double precision (`jax_enable_x64`), for the whole process; imported by what computes with JAX.

Layouts are compared to 1e-9 rad, and single precision would move them.
"""

import jax

jax.config.update("jax_enable_x64", True)
