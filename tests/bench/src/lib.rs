//! The virtual bench: the unmodified firmware image on an emulated STM32F4, with what stands around a real board.

pub mod machine;
