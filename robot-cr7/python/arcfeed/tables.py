"""Tables of a job as JSON: plain values, and those of NumPy."""

import json

import numpy as np

from . import InputError


def _plain(value, key):
    """The value as JSON knows it; key is the way to it."""
    if isinstance(value, dict):
        # A key that is None is one that is left out.
        return {
            name: _plain(one, f"{key}.{name}" if key else str(name)) for name, one in value.items() if one is not None
        }
    if isinstance(value, (list, tuple)) or (isinstance(value, np.ndarray) and value.ndim > 0):
        return [_plain(one, f"{key}[{i}]") for i, one in enumerate(value)]
    if isinstance(value, (np.generic, np.ndarray)):
        value = value.item()
    if isinstance(value, float) and not np.isfinite(value):
        raise InputError(f"{key} is {value}: it has to be a finite number")
    if not isinstance(value, (bool, int, float, str)):
        raise InputError(f"{key} is {value!r}: give a number, a text, True or False, a list or a dict")
    return value


def to_json(tables):
    """The tables of a job as JSON."""
    return json.dumps(_plain(tables, ""))
