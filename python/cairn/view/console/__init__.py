"""The live console: a run in a browser, watched and steered.

`snapshot` is the plain data it is fed with. `server` needs the extra `console`.
"""
