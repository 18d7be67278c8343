//! A folder as a library: is everything found, is only what changed read again, and does nothing get lost?

use burnish::library::edit::{self, Change};
use burnish::library::index::Index;
use burnish::library::query::Facts;
use burnish::library::scan::{Scan, Scanned};
use burnish::library::setup::{Frame, Setup, Stage};
use burnish::library::shelf::{Shelf, State};
use burnish::library::{Entry, Library, LibraryPlaces, Query};
use burnish::places::Places;
use burnish_assets::{make_environment, make_shape};
use burnish_material::{Property, Value};
use burnish_renderer::scene::{EnvironmentLight, ModelMeshes, Scene};
use burnish_tests::library::{material, path, write, write_old};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

fn scan_with(root: &Path, old: &Index, is_cancelled: &(dyn Fn() -> bool + Sync)) -> Scanned {
    let scan = Scan { root, old, threads: 2, has_picture: &|_| true, is_cancelled, tell: &|_| {} };
    scan.run().expect("the folder is there")
}

fn scan(root: &Path, old: &Index) -> Scanned {
    scan_with(root, old, &|| false)
}

fn places(folder: &Path) -> Places {
    let below = |name| Some(folder.join(name));
    Places { config: below("config"), state: below("state"), cache: below("cache") }
}

fn paths(index: &Index) -> Vec<PathBuf> {
    index.entries.iter().map(|entry| entry.path.clone()).collect()
}

/// Polls until the library is scanned and `is_done`.
fn wait(library: &mut Library, is_done: impl Fn(&Library) -> bool) {
    let start = Instant::now();
    while library.progress().is_some() || library.setup().is_none() || !is_done(library) {
        library.poll();
        assert!(start.elapsed() < Duration::from_secs(60), "it takes too long");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn only_what_changed_is_read_again() {
    const COUNT: usize = 2000;
    let folder = tempfile::tempdir().unwrap();
    let (root, file) = (folder.path().join("library"), folder.path().join("index.json"));
    write(&root, COUNT).unwrap();
    fs::create_dir(root.join("metals/maps")).unwrap();
    write_old(&root.join("metals/maps/0.png"), b"pixels", 5000).unwrap();

    let first = scan(&root, &Index::load(&file, &root));
    assert_eq!((first.read, first.images_read, first.index.entries.len()), (COUNT, 1, COUNT));
    assert!(first.is_whole && first.is_changed && first.problems.is_empty());
    let known = first.index.find(&path(7)).unwrap();
    assert_eq!((known.name.as_str(), known.problem.as_deref()), ("Sample 7 of plastics", None));
    first.index.save(&file).unwrap();

    let index = Index::load(&file, &root);
    assert!(index.entries == first.index.entries, "the index on disk differs");
    let again = scan(&root, &index);
    assert_eq!((again.read, again.images_read, again.is_changed), (0, 0, false));

    // One more, one less, one with other bytes of the same length, one image.
    let old = index.find(&path(3)).unwrap();
    let text = fs::read_to_string(root.join(path(3))).unwrap().replace("number 3", "number 4");
    write_old(&root.join(path(3)), text.as_bytes(), 4000).unwrap();
    write_old(&root.join("new.asm.ron"), b"{}", 4000).unwrap();
    fs::remove_file(root.join(path(4))).unwrap();
    write_old(&root.join("metals/maps/0.png"), b"PIXELS", 4000).unwrap();
    let changed = scan(&root, &index);
    assert_eq!((changed.read, changed.images_read, changed.is_changed), (2, 1, true));
    assert!(changed.index.find(&path(4)).is_none() && changed.index.find(Path::new("new.asm.ron")).is_some());
    let new = changed.index.find(&path(3)).unwrap();
    assert!(new.content != old.content && new.look == old.look, "notes cannot be seen");
    let painted = |index: &Index| index.find(&path(200)).unwrap().clone();
    assert!(painted(&changed.index).look != painted(&index).look);
    assert_eq!(painted(&changed.index).previous, Some(painted(&index).look));
    assert!(painted(&changed.index).textures == ["maps/0.png"]);

    // A broken or cut index costs a scan and no word.
    let bytes = fs::read(&file).unwrap();
    for broken in [&bytes[..bytes.len() / 2], b"{}", b"\xff"] {
        fs::write(&file, broken).unwrap();
        assert!(Index::load(&file, &root).entries.is_empty());
    }
    // What was just written is not trusted, because a change within the clock's step would not show.
    fs::write(root.join("new.asm.ron"), "{ }").unwrap();
    let young = scan(&root, &changed.index);
    assert_eq!((young.read, scan(&root, &young.index).read), (1, 1));
}

#[test]
fn a_scan_that_is_cancelled_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 50).unwrap();
    let whole = scan(folder.path(), &Index::default()).index;
    fs::write(folder.path().join(path(9)), "{}").unwrap();
    let cut = scan_with(folder.path(), &whole, &|| true);
    assert!(!cut.is_whole && cut.index.entries == whole.entries);
    // Cancelled after the walk, before the files.
    let asked = std::sync::atomic::AtomicUsize::new(0);
    let after_walk = || asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed) > 8;
    let cut = scan_with(folder.path(), &whole, &after_walk);
    assert!(!cut.is_whole && paths(&cut.index) == paths(&whole));
}

#[test]
fn bad_files_have_one_sentence_each_and_the_rest_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    write(root, 10).unwrap();
    fs::create_dir_all(root.join("folder.asm.ron/inner")).unwrap();
    fs::write(root.join("folder.asm.ron/inner/good.asm.ron"), "{}").unwrap();
    fs::write(root.join("bytes.asm.ron"), b"{\"name\": \"\xff\"}").unwrap();
    fs::write(root.join("cut.asm.ron"), "{\"properties\": {").unwrap();
    fs::write(root.join("empty.asm.ron"), "").unwrap();
    fs::write(root.join("list.asm.ron"), "[1]").unwrap();
    fs::write(root.join("word.asm.ron"), r#"{"properties": {"roughness": "high"}}"#).unwrap();
    fs::write(root.join("other.ron"), "not a material").unwrap();
    fs::File::create(root.join("huge.asm.ron")).unwrap().set_len(2 << 30).unwrap();
    let mut expected = vec![
        ("folder.asm.ron", "expected a file, found a folder"),
        ("bytes.asm.ron", "UTF-8"),
        ("cut.asm.ron", "line 1"),
        ("empty.asm.ron", "line 1"),
        ("list.asm.ron", "expected a map"),
        ("word.asm.ron", "roughness"),
        ("huge.asm.ron", "at most"),
    ];
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        symlink("nowhere", root.join("link.asm.ron")).unwrap();
        expected.push(("link.asm.ron", "cannot be read"));
        // Around the library, into itself, and beside.
        symlink("..", root.join("metals/up")).unwrap();
        symlink("/", root.join("metals/top")).unwrap();
        symlink(".", root.join("metals/here")).unwrap();
        for number in 0..8 {
            symlink("metals", root.join(format!("way{number}"))).unwrap();
        }
    }
    let start = Instant::now();
    let scanned = scan(root, &Index::default());
    assert!(start.elapsed() < Duration::from_secs(5), "a file of 2 GB was read: {:?}", start.elapsed());
    let broken: BTreeMap<&Path, &str> =
        scanned.index.entries.iter().filter_map(|entry| Some((entry.path.as_path(), entry.problem.as_deref()?))).collect();
    assert_eq!(broken.len(), expected.len(), "{broken:?}");
    for (name, words) in expected {
        let problem = broken[Path::new(name)];
        assert!(problem.contains(words) && !problem.contains('\n') && !problem.contains(name), "{name}: {problem}");
    }
    let good: Vec<_> = scanned.index.entries.iter().filter(|entry| entry.problem.is_none()).collect();
    assert_eq!(good.len(), 11, "each file once, by its own path");
    let is_own = |entry: &Entry| entry.path.starts_with("folder.asm.ron") || (0..10).any(|number| entry.path == path(number));
    assert!(good.iter().all(|entry| is_own(entry)));
}

#[test]
fn a_folder_that_goes_away_is_told_and_what_was_known_stays() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("library");
    write(&root, 30).unwrap();
    let mut library = Library::open(&root, &places(folder.path()), || {});
    wait(&mut library, |_| true);
    assert_eq!(library.entries().len(), 30);
    fs::remove_dir_all(root.join("metals")).unwrap();
    library.rescan();
    wait(&mut library, |_| true);
    assert_eq!(library.entries().len(), 18);
    assert!(library.take_problems().is_empty());

    fs::remove_dir_all(&root).unwrap();
    library.rescan();
    wait(&mut library, |_| true);
    let problems = library.take_problems();
    assert!(problems.len() == 1 && problems[0].contains("library: expected a folder"), "{problems:?}");
    assert_eq!(library.entries().len(), 18, "a drive may come back");

    // While it is scanned.
    write(&root, 400).unwrap();
    library.rescan();
    fs::remove_dir_all(&root).unwrap();
    wait(&mut library, |_| true);
    let problems = library.take_problems();
    assert!(problems.iter().all(|problem| problem.contains("expected a folder that can be read")), "{problems:?}");
}

#[test]
fn queries_find_what_they_say() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 400).unwrap();
    let index = scan(folder.path(), &Index::default()).index;
    let facts = |entry: &Entry| Facts {
        state: if entry.name.contains("1") { State::Fresh } else { State::Stale },
        is_favourite: entry.path == path(5),
    };
    let found = |query: &str| {
        let query = Query::parse(query);
        assert_eq!(query.problem(), None);
        index.entries.iter().filter(|entry| query.matches(entry, || facts(entry))).map(|entry| entry.path.clone()).collect()
    };
    let is = |number: usize, kinds: &[usize]| kinds.contains(&(number % 5));
    let rough = |number: usize| (!number.is_multiple_of(50)).then(|| number * 7 % 1000);
    let luminance = |number: usize| {
        let Value::Color([r, g, b]) = material(number).value(Property::base_color) else { panic!("a colour") };
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    type Expected<'a> = Box<dyn Fn(usize) -> bool + 'a>;
    let table: Vec<(&str, Expected)> = vec![
        ("", Box::new(|_| true)),
        ("  -  ", Box::new(|_| true)),
        ("metal", Box::new(|n| is(n, &[0, 1]))),
        ("METAL rough<0.3 tag:measured", Box::new(|n| is(n, &[0]) && rough(n).is_some_and(|r| r < 300))),
        ("rough < 0.3", Box::new(|n| rough(n).is_some_and(|r| r < 300))),
        ("roughness>= 30%", Box::new(|n| rough(n).is_some_and(|r| r >= 300))),
        ("-rough<0.3", Box::new(|n| rough(n).is_none_or(|r| r >= 300))),
        ("rough=0.7", Box::new(|n| rough(n) == Some(700))),
        ("group:metals", Box::new(|n| is(n, &[0, 1]))),
        ("group:worn", Box::new(|n| is(n, &[1]))),
        ("-metals", Box::new(|n| !is(n, &[0, 1]))),
        ("\"injection moulded\"", Box::new(|n| is(n, &[2]))),
        ("-\"injection moulded\" -metal", Box::new(|n| is(n, &[3, 4]))),
        ("tag:\"injection moul", Box::new(|n| is(n, &[2]))),
        ("tag:easured", Box::new(|_| false)),
        ("easured", Box::new(|_| false)),
        ("licence:CC0", Box::new(|n| n.is_multiple_of(3))),
        ("name:\"sample 5 of\"", Box::new(|n| n == 5)),
        ("fav:", Box::new(|n| n == 5)),
        ("-is:favourite", Box::new(|n| n != 5)),
        ("has:texture", Box::new(|n| n.is_multiple_of(50))),
        ("texture:normal", Box::new(|_| false)),
        ("texture:rough", Box::new(|n| n.is_multiple_of(50))),
        ("is:stale", Box::new(|n| !n.to_string().contains('1'))),
        ("is:broken", Box::new(|_| false)),
        ("coat>0", Box::new(|n| n.is_multiple_of(7) && n * 23 % 1000 > 0)),
        ("has:transmission ior>1.8", Box::new(|n| is(n, &[3]) && n * 19 % 1000 > 500)),
        ("baseColor>0.5", Box::new(|n| luminance(n) > 0.5)),
        ("notes:\"made up\" number", Box::new(|_| true)),
    ];
    for (query, expected) in table {
        let expected: std::collections::BTreeSet<PathBuf> = (0..400).filter(|n| expected(*n)).map(path).collect();
        let found: std::collections::BTreeSet<PathBuf> = found(query);
        let wrong: Vec<_> = found.symmetric_difference(&expected).take(3).collect();
        assert!(wrong.is_empty(), "`{query}` is wrong about {wrong:?}");
    }
    // A part that is wrong costs a sentence; the rest is looked for.
    for (query, words) in [
        ("metal rough<x", "expected a number after roughness"),
        ("metal spec>0", "specular_level or specular_edge_color"),
        ("metal glossiness>0", "no property"),
        ("metal colour:red", "`colour:` means nothing"),
        ("metal tag:", "expected a word"),
        ("metal is:nice", "fresh, draft, stale, missing"),
        ("metal has:wheels", "texture"),
        ("metal normal>0", "normal is a direction"),
    ] {
        let query = Query::parse(query);
        let problem = query.problem().unwrap_or_default();
        assert!(problem.contains(words) && !problem.contains('\n'), "{problem}");
        let metals = index.entries.iter().filter(|entry| query.matches(entry, || facts(entry))).count();
        assert_eq!(metals, 160, "{problem}");
    }
}

#[test]
fn shards_are_disjoint_and_together_everything() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 300).unwrap();
    let index = scan(folder.path(), &Index::default()).index;
    for count in [1, 2, 3, 7] {
        let mut sizes = vec![0; count as usize];
        for entry in &index.entries {
            sizes[entry.look.part(count) as usize] += 1;
        }
        assert_eq!(sizes.iter().sum::<usize>(), 300);
        let mean = 300 / count as usize;
        assert!(sizes.iter().all(|size| *size > mean / 2 && *size < 2 * mean.max(1)), "{sizes:?}");
    }
}

/// A setup that takes next to no time.
fn quick_setup() -> Setup {
    let model: ModelMeshes = make_shape("sphere").expect("it is built in").into();
    let map = Arc::new(make_environment("white-furnace").expect("it is built in"));
    let light = EnvironmentLight { map, rotation_deg: 0.0, scale: 1.0 };
    let scene = Scene::of_model(&model, Arc::default(), Arc::default(), light, model.unit_mm);
    let names = [Some("sphere".to_owned()), Some("white-furnace".to_owned())];
    let [shape, environment] = names;
    let frame = Frame { width: 16, height: 16, relmse: 0.01, ..Frame::default() };
    Setup::new(Stage { scene, shape, backdrop: None, environment, has_unit: true }, frame, Vec::new())
}

#[test]
fn pictures_come_for_what_is_in_sight_and_stay_on_disk() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("library");
    write(&root, 12).unwrap();
    let places = places(folder.path());
    let setup = Arc::new(quick_setup());
    let open = || {
        let mut library = Library::open(&root, &places, || {});
        wait(&mut library, |_| true);
        library.set_setup(setup.clone());
        library
    };
    let mut library = open();
    let show = |library: &mut Library, makes: bool| {
        let start = Instant::now();
        let seen = [1, 2, 5];
        let is_there = |library: &Library, n: &usize| {
            let entry = library.entries()[*n].clone();
            library.picture(&entry).is_some() && (!makes || library.state(&entry) == State::Fresh)
        };
        while !seen.iter().all(|n| is_there(library, n)) {
            library.show(&seen, makes);
            library.poll();
            assert!(start.elapsed() < Duration::from_secs(60), "pictures do not come");
            std::thread::sleep(Duration::from_millis(2));
        }
    };
    assert_eq!(library.matching(&Query::parse("is:missing")).len(), 12);
    show(&mut library, true);
    assert_eq!(library.matching(&Query::parse("is:fresh")), [1, 2, 5]);
    assert_eq!(library.picture(&library.entries()[1].clone()).map(|picture| picture.rgba.len()), Some(16 * 16 * 4));
    let shelf = Shelf::open(LibraryPlaces::of(&root, &places).pictures.as_deref().unwrap());
    assert!(shelf.path(library.entries()[1].look, setup.digest()).exists());

    // Another day: nothing is made, and all is there. Favourites are, too.
    library.change_marks(|marks| marks.set_favourite(&path(3), true));
    drop(library);
    let mut library = open();
    show(&mut library, false);
    assert_eq!(library.matching(&Query::parse("fav:")).len(), 1);

    // An edit makes it stale, and the old picture stays in sight.
    let edited = library.entries()[1].path.clone();
    let planned = edit::change(&[root.join(&edited)], &[Change::SetValue(Property::roughness, Value::Float(0.123))]);
    assert!(planned.edit.carry_out().1.is_empty());
    library.rescan();
    wait(&mut library, |_| true);
    library.set_setup(setup.clone());
    assert_eq!(library.matching(&Query::parse("is:stale")), [1]);
    show(&mut library, false);
    // A tag does not.
    let planned = edit::change(&[root.join(&edited)], &[Change::AddTag("seen".to_owned())]);
    assert!(planned.edit.carry_out().1.is_empty());
    library.rescan();
    wait(&mut library, |library| !library.matching(&Query::parse("tag:seen")).is_empty());
    assert_eq!(library.matching(&Query::parse("is:stale")), [1]);

    // All the others at once, in the order of the batch.
    library.make_all(&(0..12).collect::<Vec<_>>(), 2);
    assert_eq!((library.making().done, library.making().total), (0, 10));
    let start = Instant::now();
    while library.making().done < 10 {
        library.show(&[], false);
        library.poll();
        assert!(start.elapsed() < Duration::from_secs(60), "pictures do not come");
        std::thread::sleep(Duration::from_millis(2));
    }
    assert_eq!(library.making().seconds_left, Some(0.0));
    assert_eq!(library.matching(&Query::parse("is:fresh")).len(), 12);
}

#[test]
fn setups_are_told_apart_by_what_shows() {
    let base = quick_setup();
    assert_eq!(base.digest(), quick_setup().digest());
    let stage = || Stage::standard().unwrap();
    let of = |stage: Stage, frame: Frame, set| Setup::new(stage, frame, set).digest();
    let frame = Frame::default();
    let plain = of(stage(), frame, Vec::new());
    let mut turned = stage();
    turned.scene.environment.rotation_deg = 30.0;
    let mut closer = stage();
    closer.scene.camera.fov_deg = 20.0;
    let mut other = stage();
    other.shape = None;
    let all = [
        plain,
        base.digest(),
        of(turned, frame, Vec::new()),
        of(closer, frame, Vec::new()),
        of(other, frame, Vec::new()),
        of(stage(), Frame { width: 128, ..frame }, Vec::new()),
        of(stage(), Frame { relmse: 0.001, ..frame }, Vec::new()),
        of(stage(), Frame { seed: 1, ..frame }, Vec::new()),
        of(stage(), frame, vec![(Property::roughness, Value::Float(0.1))]),
    ];
    for (i, a) in all.iter().enumerate() {
        assert!(all[..i].iter().all(|b| b != a), "{i}");
    }
}
