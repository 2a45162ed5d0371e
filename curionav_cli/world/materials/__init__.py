"""Materials by name, drawn as images."""
