use super::*;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::Receiver;

/// Tells a child of a test which state folder to use.
const CHILD: &str = "BURNISH_TEST_RECOVERY";
/// Documents that the child has.
const DOCUMENTS: u64 = 3;

fn kept(id: u64, text: &str) -> Kept {
    let when = UNIX_EPOCH + Duration::from_secs(1_700_000_000 + id);
    let path = Some(PathBuf::from(format!("/materials/{id}.asm.ron")));
    Kept { id, path, import: None, title: format!("Document {id}"), text: text.to_owned(), original: "{}".to_owned(), when }
}

/// Names below the recovery folder.
fn sessions(state: &Path) -> Vec<String> {
    let entries = fs::read_dir(state.join(FOLDER)).unwrap();
    entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
}

/// Ends a store as a crash does, with its lock free.
fn crash(store: Store) -> PathBuf {
    store.flush().unwrap();
    let folder = store.folder.clone();
    drop(store);
    folder
}

#[test]
fn what_is_unsaved_comes_back_to_the_letter() {
    let state = tempfile::tempdir().unwrap();
    let texts = [
        "",
        "plain",
        "a\r\nb\rc\n\ttab\n",
        "\"#\"##\\u{41}\\ r#\"x\"#",
        "\u{feff}\0\u{2028}\u{1f600}",
        "{ \"asm\": \"4.0\" } // ends",
    ];
    let store = Store::open(state.path()).unwrap();
    let documents: Vec<Kept> = (0..).zip(texts).map(|(id, text)| Kept { original: text.repeat(2), ..kept(id, text) }).collect();
    store.write(documents.clone());
    assert_eq!(store.flush(), Ok(()));
    assert!(left_behind(state.path()).0.is_empty(), "the process lives");
    crash(store);
    let (found, messages) = left_behind(state.path());
    assert!(messages.is_empty(), "{messages:?}");
    let found: Vec<&Kept> = found.iter().flat_map(Abandoned::documents).collect();
    assert_eq!(found.len(), texts.len());
    for (found, document) in found.into_iter().rev().zip(&documents) {
        assert!(found == document, "{found:?}\n{document:?}");
    }
}

#[test]
fn only_what_changed_is_written_and_what_was_saved_is_removed() {
    let state = tempfile::tempdir().unwrap();
    let store = Store::open(state.path()).unwrap();
    let file = |id: u64| store.folder.join(format!("{id}.ron"));
    store.write(vec![kept(1, "a"), kept(2, "b")]);
    store.flush().unwrap();
    // Whoever wrote them again would bring them back.
    fs::write(file(1), "marked").unwrap();
    fs::write(file(2), "marked").unwrap();
    store.write(vec![Kept { when: SystemTime::now(), ..kept(1, "a") }, kept(2, "b2")]);
    store.flush().unwrap();
    assert_eq!(fs::read_to_string(file(1)).unwrap(), "marked");
    assert!(fs::read_to_string(file(2)).unwrap().contains("b2"));
    store.write(vec![kept(2, "b2")]);
    store.flush().unwrap();
    assert!(!file(1).exists() && file(2).exists());
    store.write(vec![kept(1, "a"), kept(2, "b2")]);
    store.flush().unwrap();
    assert!(file(1).exists(), "it is unsaved again");
    store.close().unwrap();
    assert!(sessions(state.path()).is_empty());
}

#[test]
fn a_failure_is_told_once_and_the_next_writing_tries_again() {
    let state = tempfile::tempdir().unwrap();
    let store = Store::open(state.path()).unwrap();
    let in_the_way = store.folder.join("1.ron");
    fs::create_dir(&in_the_way).unwrap();
    store.write(vec![kept(1, "a")]);
    assert!(store.flush().unwrap_err().contains("1.ron"));
    let problem = store.problem().unwrap();
    assert!(problem.contains("not safe") && problem.contains("1.ron"), "{problem}");
    store.write(vec![kept(1, "a")]);
    assert!(store.flush().is_err());
    assert_eq!(store.problem(), None);
    fs::remove_dir(&in_the_way).unwrap();
    store.write(vec![kept(1, "a")]);
    store.flush().unwrap();
    assert_eq!(store.problem(), None);
    assert!(in_the_way.is_file());
}

#[test]
fn nothing_is_offered_twice() {
    let state = tempfile::tempdir().unwrap();
    let first = Store::open(state.path()).unwrap();
    first.write(vec![kept(1, "a")]);
    let folder = crash(first);
    let (mut found, _) = left_behind(state.path());
    assert_eq!(found.len(), 1);
    assert!(left_behind(state.path()).0.is_empty(), "somebody is being asked about it");
    drop(found.pop());
    let (mut found, _) = left_behind(state.path());
    assert_eq!(found.len(), 1, "nobody has decided");
    found.pop().unwrap().discard().unwrap();
    assert!(left_behind(state.path()).0.is_empty() && !folder.exists());
}

#[test]
fn adopted_documents_are_written_before_they_are_discarded() {
    let state = tempfile::tempdir().unwrap();
    let first = Store::open(state.path()).unwrap();
    first.write(vec![kept(1, "a")]);
    let folder = crash(first);

    let second = Store::open(state.path()).unwrap();
    let in_the_way = second.folder.join("7.ron");
    fs::create_dir(&in_the_way).unwrap();
    let abandoned = left_behind(state.path()).0.pop().unwrap();
    let mine = vec![Kept { id: 7, ..abandoned.documents()[0].clone() }];
    second.adopt(mine.clone(), abandoned);
    assert!(second.flush().is_err());
    assert!(folder.join("1.ron").exists(), "it is nowhere else");
    fs::remove_dir(&in_the_way).unwrap();
    second.write(mine);
    second.flush().unwrap();
    assert!(in_the_way.is_file() && !folder.exists());
}

#[test]
fn damaged_documents_are_set_aside_and_the_others_offered() {
    let state = tempfile::tempdir().unwrap();
    let store = Store::open(state.path()).unwrap();
    store.write((0..4).map(|id| kept(id, &"text".repeat(100))).collect());
    let folder = crash(store);
    let text = fs::read(folder.join("1.ron")).unwrap();
    fs::write(folder.join("1.ron"), &text[..text.len() / 2]).unwrap();
    fs::write(folder.join("2.ron"), b"\xff\0").unwrap();
    fs::File::create(folder.join("3.ron")).unwrap().set_len((64 << 20) + 1).unwrap();
    fs::write(folder.join("not a document.txt"), "").unwrap();
    let (mut found, messages) = left_behind(state.path());
    assert!(found.len() == 1 && found[0].documents() == [kept(0, &"text".repeat(100))]);
    assert_eq!(messages.len(), 3, "{messages:?}");
    for (id, saying) in [(1, "renamed to 1.broken-1.ron"), (2, "renamed to 2.broken-1.ron"), (3, "stays where it is")] {
        let is_said = messages.iter().any(|message| message.contains(&format!("{id}.ron: expected")) && message.contains(saying));
        assert!(is_said, "{id}: {messages:?}");
    }
    found.pop().unwrap().discard().unwrap();
    assert!(!folder.join("0.ron").exists());
    assert!(["1.broken-1.ron", "2.broken-1.ron", "3.ron"].iter().all(|name| folder.join(name).exists()));
}

#[test]
fn many_starts_at_once_keep_their_own() {
    let state = tempfile::tempdir().unwrap();
    thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for round in 0..60 {
                    let store = Store::open(state.path()).unwrap();
                    let (found, messages) = left_behind(state.path());
                    assert!(found.is_empty() && messages.is_empty(), "{found:?} {messages:?}");
                    assert!(store.folder.join(LOCK).exists(), "its folder was taken for left behind");
                    if round % 20 == 0 {
                        store.write(vec![kept(1, "a")]);
                        store.flush().unwrap();
                    }
                    store.close().unwrap();
                }
            });
        }
    });
    assert!(sessions(state.path()).is_empty());
}

/// The text of a version, long enough to be cut off while it is written.
fn text_of(version: u64) -> String {
    format!("version {version}\n").repeat(20_000)
}

/// What the child of the next test does until it is killed: as the editor, but without pausing.
fn write_until_killed(state: &Path) {
    let store = Store::open(state).unwrap();
    for version in 1..10_000 {
        store.write((0..DOCUMENTS).map(|id| kept(id, &text_of(version))).collect());
        store.flush().unwrap();
        println!("\nkept {version}");
    }
}

/// Starts the child; the receiver gets the versions that it says are on disk, and ends with it.
fn start_child(state: &Path) -> (Child, Receiver<u64>) {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "recovery::tests::a_killed_process_loses_no_more_than_one_autosave", "--nocapture"]);
    let mut child = command.env(CHILD, state).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let (sender, receiver) = channel();
    thread::spawn(move || {
        let versions = lines.map_while(Result::ok).filter_map(|line| line.strip_prefix("kept ")?.parse().ok());
        versions.for_each(|version| sender.send(version).unwrap());
    });
    (child, receiver)
}

#[test]
fn a_killed_process_loses_no_more_than_one_autosave() {
    if let Some(state) = std::env::var_os(CHILD) {
        return write_until_killed(Path::new(&state));
    }
    let state = tempfile::tempdir().unwrap();
    let mut random = 1_u64;
    for round in 0..20 {
        let (mut child, versions) = start_child(state.path());
        versions.recv_timeout(Duration::from_secs(60)).unwrap();
        assert!(left_behind(state.path()).0.is_empty(), "the process lives");
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        thread::sleep(Duration::from_millis(50 + (random >> 33) % 250));
        child.kill().unwrap();
        child.wait().unwrap();
        let last = versions.iter().max().unwrap_or(1);

        let (mut found, messages) = left_behind(state.path());
        assert!(messages.is_empty(), "{messages:?}");
        assert_eq!(found.len(), 1);
        let documents = found[0].documents();
        assert_eq!(documents.len() as u64, DOCUMENTS);
        for document in documents {
            let version = [last, last + 1].into_iter().find(|version| document.text == text_of(*version));
            assert!(version.is_some(), "round {round}: not version {last} or the next: {:.40}", document.text);
        }
        found.pop().unwrap().discard().unwrap();
        assert_eq!(sessions(state.path()), Vec::<String>::new(), "everything of it is gone");
    }
}
