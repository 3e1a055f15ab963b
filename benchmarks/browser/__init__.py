"""Pages of results in Chromium: `made` makes them, `session` opens them, `screen`, `charts` and `paper` look at them,
`looked` puts together what they find."""
