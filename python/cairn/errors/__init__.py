"""Every way that input can be wrong: one class per cause, the offending values as attributes.

Errors of the brain arrive as the class of the same name. All are `ValueError`s, so code that does
not care which one it was can catch that.
"""

from cairn.errors.base import CairnError as CairnError

from .driving import *
from .planning import *
from .views import *
from .worlds import *
