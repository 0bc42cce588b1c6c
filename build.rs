//! Links OpenBLAS if the feature `sdp` is enabled, and does nothing else.
//!
//! The cone solver leaves the choice of BLAS and LAPACK to the final program. Its own feature that
//! builds OpenBLAS downloads the source; this one takes the library that the system's package
//! manager installs.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var_os("CARGO_FEATURE_SDP").is_some() {
        println!("cargo:rustc-link-lib=openblas");
    }
}
