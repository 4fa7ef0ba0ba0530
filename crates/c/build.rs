//! Build script: sets the soname of the shared library.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // until 1.0, every minor version may change the interface
    let version = |part: &str| std::env::var(format!("CARGO_PKG_VERSION_{part}")).unwrap_or_default();
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "linux") {
        let name = format!("libclearance.so.{}.{}", version("MAJOR"), version("MINOR"));
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,{name}");
    }
}
