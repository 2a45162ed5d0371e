"""Settings: what may be set (schema.py) and how it is composed (the only room that knows Hydra)."""
