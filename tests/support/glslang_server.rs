//! glslang as a process that compiles text after text: the start of `glslangValidator` takes longer than
//! most texts.
//!
//! Built with `g++` from `glslang_server.cpp`; needs the Debian package `glslang-dev`.

use std::io::{self, BufReader, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::{Mutex, OnceLock, PoisonError};

use super::glslang::Client;

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

struct Server {
    process: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
}

/// Builds the server, unless that was done since its source changed.
fn program() -> &'static Path {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(|| {
        // Of the workspace, also where a crate's own test starts it.
        let package = Path::new(env!("CARGO_MANIFEST_DIR"));
        let folders = [".", "../.."].map(|up| package.join(up).join("tests/support"));
        let folder = folders.into_iter().find(|folder| folder.is_dir());
        let source = folder.expect("the workspace has the folder").join("glslang_server.cpp");
        let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("glslang_server");
        let changed = |path: &Path| path.metadata().and_then(|found| found.modified()).ok();
        if changed(&program) < changed(&source) {
            // Test programs that run side by side do not meet in one file.
            let built = program.with_extension(std::process::id().to_string());
            let mut compiler = Command::new("g++");
            compiler.args(["-O1", "-std=c++17"]).arg(source).arg("-o").arg(&built).args(LIBRARIES);
            let status = compiler.status().expect("g++ runs");
            assert!(status.success(), "the Debian package `glslang-dev` is needed");
            std::fs::rename(built, &program).expect("it is moved");
        }
        program
    })
}

/// Compiles a text with a server that is free, or else a new one; the words of its SPIR-V, or the log.
/// `stage` is glslang's word.
pub fn compiled(text: &str, stage: &str, client: Client) -> Result<Vec<u32>, String> {
    static FREE: Mutex<Vec<Server>> = Mutex::new(Vec::new());
    let free = || FREE.lock().unwrap_or_else(PoisonError::into_inner);
    let taken = free().pop();
    let mut server = taken.unwrap_or_else(Server::start);
    // Some texts end glslang.
    let answer = server.compile(text, stage, client).map_err(|ended| ended.to_string())?;
    free().push(server);
    answer
}

impl Server {
    fn start() -> Server {
        let mut command = Command::new(program());
        // glslang prints its own tables where it fails.
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut process = command.spawn().expect("the server starts");
        let (requests, answers) = (process.stdin.take(), process.stdout.take());
        Server {
            process,
            requests: requests.expect("it is piped"),
            answers: BufReader::new(answers.expect("it is piped")),
        }
    }

    fn compile(
        &mut self,
        text: &str,
        stage: &str,
        client: Client,
    ) -> io::Result<Result<Vec<u32>, String>> {
        // EShLanguage.
        let stage: u32 = match stage {
            "vert" => 0,
            "tesc" => 1,
            "tese" => 2,
            "geom" => 3,
            "frag" => 4,
            "comp" => 5,
            other => panic!("a stage that the server does not have: {other}"),
        };
        let client = u32::from(client == Client::OpenGl);
        let head = [stage, text.len() as u32, client].map(u32::to_le_bytes).concat();
        self.requests.write_all(&head)?;
        self.requests.write_all(text.as_bytes())?;
        let count = self.word()?;
        let words = (0..count).map(|_| self.word()).collect::<io::Result<Vec<u32>>>()?;
        let mut log = vec![0; self.word()? as usize];
        self.answers.read_exact(&mut log)?;
        let log = || String::from_utf8_lossy(&log).into_owned();
        Ok(if words.is_empty() { Err(log()) } else { Ok(words) })
    }

    fn word(&mut self) -> io::Result<u32> {
        let mut bytes = [0; 4];
        self.answers.read_exact(&mut bytes)?;
        Ok(u32::from_le_bytes(bytes))
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
