//! The real binary in a folder of its own: what it prints, writes and returns.

mod binary;
mod check;
mod compare;
mod convert;
mod export;
mod plan;
mod simulate;
mod streams;
