//! Joining a patch to the rim of its hole.
