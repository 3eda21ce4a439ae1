//! glslang as a process that compiles text after text, for campaigns of many thousands.
//!
//! Built with `g++` from `glslang_server.cpp`; needs the Debian package `glslang-dev`.

use std::io::{BufReader, Read as _, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::OnceLock;

use super::glslang::Client;
use super::leaf::OracleBlock;
use super::spirv;

const LIBRARIES: &[&str] = &[
    "-lglslang",
    "-lMachineIndependent",
    "-lGenericCodeGen",
    "-lglslang-default-resource-limits",
    "-lSPIRV",
    "-lOGLCompiler",
    "-lOSDependent",
    "-lSPIRV-Tools-opt",
    "-lSPIRV-Tools",
    "-lpthread",
];

pub struct Server {
    process: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Server {
    /// Starts a server, and builds it once.
    pub fn start() -> Server {
        static BUILT: OnceLock<String> = OnceLock::new();
        let program = BUILT.get_or_init(|| {
            // Of the workspace, also where a crate's own test starts it.
            let package = Path::new(env!("CARGO_MANIFEST_DIR"));
            let folders = [".", "../.."].map(|up| package.join(up).join("tests/support"));
            let folder = folders.into_iter().find(|folder| folder.is_dir());
            let folder = folder.expect("the workspace has the folder");
            let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("glslang_server");
            let mut compiler = Command::new("g++");
            compiler.args(["-O1", "-std=c++17"]).arg(folder.join("glslang_server.cpp"));
            compiler.arg("-o").arg(&program).args(LIBRARIES);
            let status = compiler.status().expect("g++ runs");
            assert!(status.success(), "the Debian package `glslang-dev` is needed");
            program.display().to_string()
        });
        let mut command = Command::new(program);
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut process = command.spawn().expect("the server starts");
        let (requests, answers) = (process.stdin.take(), process.stdout.take());
        Server {
            process,
            requests: requests.expect("it is piped"),
            answers: BufReader::new(answers.expect("it is piped")),
        }
    }

    /// The blocks of a text, in order of use; nothing if glslang refuses it. `stage` is `vert`,
    /// `frag` or `comp`.
    pub fn blocks(&mut self, text: &str, stage: &str) -> Option<Vec<OracleBlock>> {
        let (words, _) = self.compile(text, stage, Client::Vulkan);
        (!words.is_empty()).then(|| spirv::blocks(&words).expect("it is SPIR-V"))
    }

    /// Whether glslang takes a text; if not, its log.
    pub fn verdict(&mut self, text: &str, stage: &str, client: Client) -> Result<(), String> {
        let (words, log) = self.compile(text, stage, client);
        if words.is_empty() { Err(log) } else { Ok(()) }
    }

    fn compile(&mut self, text: &str, stage: &str, client: Client) -> (Vec<u32>, String) {
        // EShLanguage.
        let stage: u32 = match stage {
            "vert" => 0,
            "frag" => 4,
            _ => 5,
        };
        let client = u32::from(client == Client::OpenGl);
        let head = [stage, text.len() as u32, client].map(u32::to_le_bytes).concat();
        self.requests.write_all(&head).expect("the server reads");
        self.requests.write_all(text.as_bytes()).expect("the server reads");
        self.requests.flush().expect("the server reads");
        let count = self.word();
        let words: Vec<u32> = (0..count).map(|_| self.word()).collect();
        let mut log = vec![0; self.word() as usize];
        self.answers.read_exact(&mut log).expect("the server answers");
        (words, String::from_utf8_lossy(&log).into_owned())
    }

    fn word(&mut self) -> u32 {
        let mut bytes = [0; 4];
        self.answers.read_exact(&mut bytes).expect("the server answers");
        u32::from_le_bytes(bytes)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
