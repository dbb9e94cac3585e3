//! The virtual motor.
