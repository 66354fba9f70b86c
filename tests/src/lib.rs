//! What whole-system tests stand on.

pub mod cpio;
pub mod kernel;
pub mod system;
pub mod uhid;
pub mod virtual_zed2;
