//! Integration tests, one binary; modules in reading order: the part, the dry run, the cable, and the whole story.

mod hostile;
mod link;
mod part;
mod recordings;
mod simulate;
