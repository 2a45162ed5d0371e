"""Settings: what may be set (schema.py) and how it is composed; the only package that imports Hydra."""
