"""Scanned buildings: meshes of triangles as worlds (docs/scans.md)."""
