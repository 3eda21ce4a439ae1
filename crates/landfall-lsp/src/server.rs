//! The state of the server, and the loop that answers the client.

use std::collections::{HashMap, HashSet, VecDeque};
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Sender, after, never, select, unbounded};
use gen_lsp_types::Diagnostic;
use landfall_check::stop::StopFlag;
use landfall_ir::stack::spawn_alike;
use landfall_layout::source::OpenFiles;
use lsp_server::{ErrorCode, Message, Notification, Request, RequestId, Response, ResponseError};
use serde_json::Value;

use crate::background::{self, PassJob, PassResult};
use crate::client::{Client, ClientSupport};
use crate::command_texts::CommandTexts;
use crate::documents::Documents;
use crate::laid_out::LayoutCache;
use crate::messages::{self, SentMessage};
use crate::processes::{CommandResult, RunningCommand};
use crate::project::Project;
use crate::settings::EditorSettings;

/// The time after the last edit from which all shaders are checked.
const PAUSE: Duration = Duration::from_millis(200);

/// How far the client has come in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    Starting,
    Running,
    ShutDown,
}

/// The state of the server.
pub struct EditorServer {
    pub texts: CommandTexts,
    pub client: Client,
    pub support: ClientSupport,
    pub phase: Phase,
    /// The directory that paths in findings begin in.
    pub current: PathBuf,
    pub folders: Vec<PathBuf>,
    pub settings: EditorSettings,
    pub documents: Documents,
    pub layouts: LayoutCache,
    pub projects: Vec<Project>,
    /// The project of each open document.
    pub project_of: HashMap<PathBuf, usize>,
    /// Open documents that have changed since they were checked.
    pub edited: HashSet<PathBuf>,
    /// When all shaders are to be checked again.
    pub due: Option<Instant>,
    /// The findings that the client has.
    pub published: HashMap<PathBuf, Vec<Diagnostic>>,
    jobs: Sender<PassJob>,
    /// The pass that runs: its project, and the flag that ends it.
    pub running: Option<(usize, StopFlag)>,
    /// The request for the settings that the client is to answer.
    pub asked_settings: Option<RequestId>,
    /// The commands that run, and how their results come.
    pub running_commands: HashMap<RequestId, RunningCommand>,
    pub command_results: Sender<CommandResult>,
}

/// Answers the client on standard input and output until it leaves; whether it did so in order.
///
/// # Errors
///
/// The threads that read, write and check cannot be started.
pub fn serve(texts: CommandTexts) -> io::Result<bool> {
    let (to_send, sent) = unbounded();
    let (reader, received) = unbounded();
    let (jobs, waiting_jobs) = unbounded();
    let (results, passes) = unbounded();
    let (command_results, commands) = unbounded();
    // Waits for the client's next message, also when the server has ended.
    std::thread::Builder::new()
        .name("reader".to_string())
        .spawn(move || messages::read(&mut io::stdin().lock(), &reader))?;
    std::thread::scope(|scope| {
        std::thread::Builder::new()
            .name("writer".to_string())
            .spawn_scoped(scope, move || messages::write(&mut io::stdout().lock(), &sent))?;
        spawn_alike(scope, move || background::run(&waiting_jobs, &results))?;
        let mut server = EditorServer::new(texts, to_send, jobs, command_results)?;
        let is_in_order = server.run(&received, &passes, &commands);
        if let Some((_, stop)) = &server.running {
            stop.set();
        }
        server.running_commands.values().for_each(|command| command.stop.set());
        Ok(is_in_order)
    })
}

impl EditorServer {
    fn new(
        texts: CommandTexts,
        to_send: Sender<SentMessage>,
        jobs: Sender<PassJob>,
        command_results: Sender<CommandResult>,
    ) -> io::Result<EditorServer> {
        Ok(EditorServer {
            texts,
            client: Client::new(to_send),
            support: ClientSupport::default(),
            phase: Phase::Starting,
            current: std::env::current_dir()?,
            folders: Vec::new(),
            settings: EditorSettings::default(),
            documents: Documents::default(),
            layouts: LayoutCache::default(),
            projects: Vec::new(),
            project_of: HashMap::new(),
            edited: HashSet::new(),
            due: None,
            published: HashMap::new(),
            jobs,
            running: None,
            asked_settings: None,
            running_commands: HashMap::new(),
            command_results,
        })
    }

    /// Answers until the client says `exit` or its messages end.
    fn run(
        &mut self,
        received: &Receiver<SentMessage>,
        passes: &Receiver<PassResult>,
        commands: &Receiver<CommandResult>,
    ) -> bool {
        let mut queue: VecDeque<SentMessage> = VecDeque::new();
        loop {
            queue.extend(received.try_iter());
            self.drop_cancelled(&mut queue);
            if let Some(next) = queue.pop_front() {
                if let SentMessage::Message(Message::Notification(note)) = &next {
                    if note.method == "exit" {
                        return self.phase == Phase::ShutDown;
                    }
                }
                self.take(next);
                continue;
            }
            self.survive("a check", EditorServer::check_edited);
            let pause = match self.due {
                Some(due) if self.running.is_none() => {
                    after(due.saturating_duration_since(Instant::now()))
                }
                _ => never(),
            };
            select! {
                recv(received) -> next => match next {
                    Ok(next) => queue.push_back(next),
                    // The client has gone.
                    Err(_) => return false,
                },
                recv(passes) -> result => if let Ok(result) = result {
                    self.survive("a check", |server| server.finish_pass(result));
                },
                recv(commands) -> result => if let Ok(result) = result {
                    self.survive("a command", |server| server.finish_command(result));
                },
                recv(pause) -> _ => self.survive("a check", EditorServer::begin_pass),
            }
        }
    }

    /// Answers requests that wait and were cancelled, and ends a command that runs.
    fn drop_cancelled(&mut self, queue: &mut VecDeque<SentMessage>) {
        let cancelled: Vec<RequestId> = queue.iter().filter_map(cancelled).collect();
        for id in cancelled {
            if let Some(command) = self.running_commands.get(&id) {
                command.stop.set();
            }
            queue.retain(|one| {
                let is_it =
                    matches!(one, SentMessage::Message(Message::Request(request)) if request.id == id);
                if is_it {
                    self.client.respond(Response::new_err(
                        id.clone(),
                        ErrorCode::RequestCanceled as i32,
                        "the request was cancelled".to_string(),
                    ));
                }
                !is_it
            });
        }
        queue.retain(|one| cancelled_by(one).is_none());
    }

    fn take(&mut self, received: SentMessage) {
        match received {
            SentMessage::Malformed(cause) => self.client.malformed(&cause),
            SentMessage::Message(Message::Request(request)) => self.request(request),
            SentMessage::Message(Message::Notification(note)) => {
                let method = note.method.clone();
                self.survive(&method, |server| server.notification(note));
            }
            SentMessage::Message(Message::Response(response)) => {
                self.survive("a response", |server| server.response(response));
            }
        }
    }

    fn request(&mut self, request: Request) {
        let id = request.id.clone();
        let method = request.method.clone();
        let answered = catch_unwind(AssertUnwindSafe(|| self.answer(request)));
        let result = match answered {
            Ok(Ok(Some(value))) => Ok(value),
            // Answered when its command has ended.
            Ok(Ok(None)) => return,
            Ok(Err(error)) => Err(error),
            Err(_) => {
                let message = format!("{method} made landfall panic, which is a bug in landfall");
                Err(error(ErrorCode::InternalError, message))
            }
        };
        self.client.respond(Response { id, response_result: result });
    }

    /// Runs what answers no request; a panic in it is logged.
    fn survive(&mut self, what: &str, run: impl FnOnce(&mut EditorServer)) {
        if catch_unwind(AssertUnwindSafe(|| run(self))).is_err() {
            self.client.log(&format!("{what} made landfall panic, which is a bug in landfall"));
        }
    }

    fn notification(&mut self, note: Notification) {
        if self.phase != Phase::Running && note.method != "initialized" {
            return;
        }
        if let Err(cause) = self.notified(note) {
            self.client.log(&cause);
        }
    }

    /// The open texts as they are now.
    pub fn open_files(&self) -> Arc<OpenFiles> {
        Arc::new(self.documents.texts(&self.current))
    }

    /// The absolute path of a file as findings have it.
    pub fn absolute(&self, shown: &str) -> PathBuf {
        landfall_check::config::absolute(&self.current, Path::new(shown))
    }

    /// Starts a pass over the shaders of a project that have changed.
    fn begin_pass(&mut self) {
        let open = self.open_files();
        let Some(index) = self.projects.iter().position(|project| project.is_stale) else {
            self.due = None;
            return;
        };
        let project = &mut self.projects[index];
        project.is_stale = false;
        let Some(setup) = project.setup.clone().filter(|setup| !setup.paths.is_empty()) else {
            return;
        };
        let Some(memory) = project.memory.take() else { return };
        let stop = StopFlag::default();
        let job = PassJob {
            project: index,
            generation: project.generation,
            setup,
            open,
            memory,
            stop: stop.clone(),
        };
        if self.jobs.send(job).is_ok() {
            self.running = Some((index, stop));
        }
    }

    fn finish_pass(&mut self, result: PassResult) {
        self.running = None;
        let Some(project) = self.projects.get_mut(result.project) else { return };
        let is_current = project.generation == result.generation;
        project.memory = Some(if is_current { result.memory } else { Default::default() });
        match result.found.filter(|_| is_current) {
            Some(found) => {
                // What was edited meanwhile stays as it was checked, and what is not saved at all.
                if !project.is_stale {
                    let open: HashSet<String> = setup_paths(project, &self.documents);
                    project.since.retain(|shown, _| {
                        open.contains(shown) && !found.shaders.contains_key(shown)
                    });
                }
                project.found = found;
                self.publish_all();
                if self.support.refreshes_hints {
                    // Shaders that include an open file are known now.
                    self.client.request("workspace/inlayHint/refresh", Value::Null);
                }
            }
            None => project.is_stale = true,
        }
        if self.projects.iter().any(|project| project.is_stale) {
            self.due.get_or_insert_with(|| Instant::now() + PAUSE);
        } else {
            self.due = None;
        }
    }

    /// Ends a pass that runs, as its files have changed, and has all shaders checked after a pause.
    pub fn postpone_pass(&mut self, index: usize) {
        if let Some((running, stop)) = &self.running {
            if *running == index {
                stop.set();
            }
        }
        if let Some(project) = self.projects.get_mut(index) {
            project.is_stale = true;
        }
        self.due = Some(Instant::now() + PAUSE);
    }
}

/// The paths of the open documents as a project's findings have them.
fn setup_paths(project: &Project, documents: &Documents) -> HashSet<String> {
    let Some(setup) = &project.setup else { return HashSet::new() };
    documents.paths().map(|path| setup.shown(path)).collect()
}

/// The number of the request that a message cancels.
fn cancelled(received: &SentMessage) -> Option<RequestId> {
    let id = cancelled_by(received)?;
    match id {
        Value::Number(number) => {
            number.as_i64().and_then(|n| i32::try_from(n).ok()).map(RequestId::from)
        }
        Value::String(text) => Some(RequestId::from(text.clone())),
        _ => None,
    }
}

fn cancelled_by(received: &SentMessage) -> Option<&Value> {
    match received {
        SentMessage::Message(Message::Notification(note)) if note.method == "$/cancelRequest" => {
            Some(note.params.get("id").unwrap_or(&Value::Null))
        }
        _ => None,
    }
}

/// An error for the client.
pub fn error(code: ErrorCode, message: impl Into<String>) -> ResponseError {
    ResponseError { code: code as i32, message: message.into(), data: None }
}
