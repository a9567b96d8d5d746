from hypothesis import settings

# The first call of a kernel compiles it or loads it from disk: no example may be judged by the clock.
settings.register_profile("kernels", deadline=None)
settings.load_profile("kernels")
