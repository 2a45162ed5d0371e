"""A robot that drifts: its true body, what it senses, what it believes, and how it goes home."""
