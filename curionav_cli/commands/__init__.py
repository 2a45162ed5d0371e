"""One file a command, and the modules that print: compose, build, call, print."""
