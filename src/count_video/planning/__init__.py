"""Before filming: what a set-up will count, how sure that is, and whether a camera can see it."""
