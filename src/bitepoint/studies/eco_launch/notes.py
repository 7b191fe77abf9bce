"""What has to be said beside the figures."""

NOTES = ()
