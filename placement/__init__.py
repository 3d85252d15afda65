"""Where the cameras of a ring should sit.

Importing this package switches JAX to double precision (`jax_enable_x64`) for the whole process: layouts are
compared to 1e-9 rad, and single precision would move them.
"""

import jax

jax.config.update("jax_enable_x64", True)
