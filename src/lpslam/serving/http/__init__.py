"""The HTTP API: Starlette and FastAPI over the core that agents use too."""
