//! Test helper: installs the C library with CMake, moves its folder, and compiles and runs programs against it.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{output_of, root};

/// An installation in a temporary folder.
pub struct Installation {
    folder: tempfile::TempDir,
    include: String,
    library: String,
}

impl Installation {
    /// Installs the library that cargo has built for this test.
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("there is room for an installation");
        let built = std::env::current_exe().expect("this test has a path");
        let built = built.parent().expect("this test is in a folder");
        let (build, first) = (folder.path().join("build"), folder.path().join("first prefix"));
        let mut configure = Command::new("cmake");
        configure.arg("-S").arg(root().join("crates/c")).arg("-B").arg(&build);
        output_of("configuration", configure.arg(format!("-DCLEARANCE_BUILT={}", built.display())));
        let mut install = Command::new("cmake");
        output_of("installation", install.arg("--install").arg(&build).arg("--prefix").arg(&first));
        // what is installed can be moved
        let prefix = folder.path().join("prefix");
        std::fs::rename(&first, &prefix).expect("the installation is moved");
        let text = |path: PathBuf| path.to_str().expect("the temporary folder is UTF-8").to_owned();
        let (include, library) = (text(prefix.join("include")), text(prefix.join("lib")));
        Self { folder, include, library }
    }

    /// A folder that is not in the prefix can not be moved with it.
    pub fn absolute_folders_are_rejected(&self) {
        for folder in ["CMAKE_INSTALL_LIBDIR", "CMAKE_INSTALL_INCLUDEDIR"] {
            let mut configure = Command::new("cmake");
            configure.arg("-S").arg(root().join("crates/c")).arg("-B").arg(self.folder().join(folder));
            configure.arg(format!("-DCLEARANCE_BUILT={}", self.prefix().display()));
            let output = configure.arg(format!("-D{folder}=/opt/lib")).output().expect("cmake starts");
            let text = String::from_utf8_lossy(&output.stderr);
            assert!(!output.status.success() && text.contains(&format!("{folder} is '/opt/lib'")), "{text}");
        }
    }

    /// The temporary folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    fn prefix(&self) -> PathBuf {
        self.folder().join("prefix")
    }

    /// Options for the shared library.
    pub fn shared(&self) -> [&str; 5] {
        ["-L", &self.library, "-lclearance", "-lm", "-pthread"]
    }

    /// Options for the static library, with those of `Libs.private` in its pkg-config file.
    pub fn archive(&self) -> [&str; 8] {
        ["-L", &self.library, "-l:libclearance.a", "-lgcc_s", "-lpthread", "-lm", "-ldl", "-lc"]
    }

    /// Compiles a program of this folder, with Eigen where Debian has it.
    pub fn compile(&self, compiler: &str, program: &str, options: &[&[&str]], made: &Path) {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let extension = if compiler.ends_with("++") { "cpp" } else { "c" };
        let mut command = Command::new(compiler);
        command.arg(here.join(program).with_extension(extension)).arg("-o").arg(made);
        command.args(["-I", &self.include, "-isystem", "/usr/include/eigen3"]);
        command.args(options.concat());
        output_of(program, &mut command);
    }

    /// Runs a program in the root of the project.
    pub fn run(&self, what: &str, program: &Path, arguments: &[&str]) -> String {
        let mut command = Command::new(program);
        command.args(arguments).current_dir(root()).env("LD_LIBRARY_PATH", &self.library);
        output_of(what, &mut command)
    }

    /// Builds the examples by `find_package` and one of them by pkg-config, and compares what they print with the pages.
    pub fn examples(&self, has_ompl: bool) {
        let examples = root().join("examples/cpp");
        let build = self.folder().join("examples");
        let mut configure = Command::new("cmake");
        configure.arg("-S").arg(&examples).arg("-B").arg(&build);
        output_of("examples", configure.arg(format!("-DCMAKE_PREFIX_PATH={}", self.prefix().display())));
        output_of("examples", Command::new("cmake").arg("--build").arg(&build));
        let states = output_of("check_states", Command::new(build.join("check_states")).current_dir(root()));
        let plan = output_of("plan", Command::new(build.join("plan")).current_dir(root()));
        let page = std::fs::read_to_string(root().join("docs/plan/cpp.md")).expect("the page is there");
        assert!(page.contains(states.trim_end()), "docs/plan/cpp.md shows another output than:\n{states}");
        let program =
            std::fs::read_to_string(examples.join("check_states.cpp")).expect("the example is there");
        // without the comment at the beginning
        let (_, program) = program.split_once("\n\n").expect("the example begins with a comment");
        assert!(
            page.contains(program.trim_end()),
            "docs/plan/cpp.md does not show examples/cpp/check_states.cpp"
        );
        assert!(plan.contains("verified: yes"), "{plan}");
        if has_ompl {
            let planned = output_of("ompl_plan", Command::new(build.join("ompl_plan")).current_dir(root()));
            assert!(planned.contains("verified: yes"), "{planned}");
        }

        let mut flags = Command::new("pkg-config");
        flags
            .args(["--cflags", "--libs", "clearance"])
            .env("PKG_CONFIG_PATH", self.prefix().join("lib/pkgconfig"));
        let flags = output_of("pkg-config", &mut flags);
        let made = self.folder().join("by_pkg_config");
        // as a shell splits them; the prefix has no blanks
        let mut compile = Command::new("g++");
        compile.arg("-std=c++17").arg(examples.join("check_states.cpp")).arg("-o").arg(&made);
        output_of("compilation with pkg-config", compile.args(flags.split_whitespace()));
        assert_eq!(self.run("check_states", &made, &[]), states);
    }
}
