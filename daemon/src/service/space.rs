//! Is there enough shared memory? Asked before anything is made.
