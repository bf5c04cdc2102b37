//! Tests of what can be drawn with, through the public interface.

mod curves;
mod wavy;
