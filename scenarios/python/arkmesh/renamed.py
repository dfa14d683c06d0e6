"""Former names of arguments, which work for one version and warn."""
import functools
import warnings
from typing import Any, Callable, TypeVar

_Call = TypeVar("_Call", bound=Callable[..., Any])


def warn(former: str, now: str, level: int) -> None:
    warnings.warn(f"{former} is now called {now}; the next version removes the former name", DeprecationWarning, level + 1)


def renamed(**names: str) -> Callable[[_Call], _Call]:
    """Of a function whose arguments had other names: former=now."""
    def wrap(call: Any) -> Any:
        @functools.wraps(call)
        def taken(*args: Any, **named: Any) -> Any:
            for former in names.keys() & named.keys():
                if names[former] in named:
                    raise TypeError(f"{call.__name__}() got {names[former]} twice, once as {former}")
                warn(f"{former}= of {call.__name__}()", names[former] + "=", 2)
                named[names[former]] = named.pop(former)
            return call(*args, **named)
        return taken
    return wrap
