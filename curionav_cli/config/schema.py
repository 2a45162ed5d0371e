"""Every setting's type and range, as plain dataclasses; the values stand in conf/, once.

A field without a default has its value in a YAML file. __post_init__ raises ValueError with
'key: what is wrong' for a value that its type allows and its meaning does not.
"""

from __future__ import annotations
