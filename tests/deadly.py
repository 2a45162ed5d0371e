"""Text that begins a program which kills itself: by SIGKILL, right after something was done, as a power cut would."""

DEADLY = """
import os, signal, sys
from curionav_cli import app

moment = sys.argv.pop(1)
def at(owner, name, when):
    plain = getattr(owner, name)
    def wrapped(*args, **kwargs):
        result = plain(*args, **kwargs)
        if when(*args): os.kill(os.getpid(), signal.SIGKILL)
        return result
    setattr(owner, name, wrapped)
"""
