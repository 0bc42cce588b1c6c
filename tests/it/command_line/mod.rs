//! The real binary in a folder of its own: what it prints, writes and returns.

mod binary;
mod browser;
mod check;
mod compare;
mod convert;
mod export;
mod plan;
mod report;
mod simulate;
mod streams;
