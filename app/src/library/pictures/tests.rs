use super::renderer::Outcome;
use super::*;
use crate::library::index::Index;
use crate::library::maker::Limits;
use crate::library::scan::Scan;
use crate::library::setup::{Frame, Stage};
use burnish_assets::{make_environment, make_shape};
use burnish_material::{Material, MaterialFile, Property, Value};
use burnish_renderer::path::Kept;
use burnish_renderer::scene::{EnvironmentLight, ModelMeshes, Scene};
use std::time::Duration;

/// The entries of a folder with these files.
fn entries(root: &Path, files: &[(&str, String)]) -> Vec<Arc<Entry>> {
    std::fs::create_dir(root).unwrap();
    for (name, text) in files {
        std::fs::write(root.join(format!("{name}.asm.ron")), text).unwrap();
    }
    let scan = Scan { root, old: &Index::default(), threads: 1, has_picture: &|_| false, is_cancelled: &|| false, tell: &|_| {} };
    scan.run().unwrap().index.entries
}

#[test]
fn drafts_come_first_and_are_not_kept() {
    let folder = tempfile::tempdir().unwrap();
    let (root, kept) = (folder.path().join("library"), folder.path().join("pictures"));
    let presets = &burnish_presets::presets()[..2];
    let entries = entries(&root, &[0, 1].map(|k| (["a", "b"][k], presets[k].text.to_owned())));
    let frame = Frame { width: 16, height: 16, relmse: 0.5, ..Frame::default() };
    let setup = Arc::new(Setup::new(Stage::standard().unwrap(), frame, Vec::new()));
    let mut pictures = Pictures::new(&root, Some(&kept), Arc::new(|| {}));
    let mut shelf = Shelf::empty(&kept);
    let state = |pictures: &Pictures, shelf: &Shelf, entry: usize| pictures.best(&entries[entry], shelf, setup.digest());
    pictures.want(&entries.iter().collect::<Vec<_>>(), &shelf, &setup, true);
    let start = Instant::now();
    while (0..2).any(|entry| state(&pictures, &shelf, entry).0 != State::Fresh) {
        assert!(start.elapsed() < Duration::from_secs(60), "they do not come");
        let Ok(Done::Made(new)) = pictures.results.recv_timeout(Duration::from_secs(60)) else { panic!("it does not come") };
        let (is_draft, key) = (new.is_draft, new.key);
        let entry = entries.iter().position(|entry| entry.path == new.path).unwrap();
        assert_eq!(new.thumbnail.width, if is_draft { 8 } else { 16 });
        assert_eq!(shelf.path(key.0, key.1).exists(), !is_draft);
        let drafts = pictures.drafts.len();
        assert!(drafts == entry || !is_draft, "drafts in the order of the entries, before all others");
        pictures.take(Done::Made(new), &mut shelf, &mut Vec::new());
        let expected = if is_draft { State::Draft } else { State::Fresh };
        assert_eq!(state(&pictures, &shelf, entry), (expected, Some(key)));
        assert_eq!((key.1 == setup.digest(), shelf.has_any(key.0)), (!is_draft, !is_draft), "the shelf knows no drafts");
        assert!(pictures.get(key).is_some());
    }
    assert!(pictures.drafts.is_empty() && pictures.made.len() == 2, "what is there in full is not kept as a draft");
    assert_eq!(pictures.memory_bytes(), 2 * 16 * 16 * 4);
}

/// A sphere in the dark, and two materials: the first shines and has edges whose error never is small enough, the second has no noise at all.
fn slow_and_quick(root: &Path) -> (Vec<Arc<Entry>>, Arc<Setup>) {
    let model: ModelMeshes = make_shape("sphere").unwrap().into();
    let light = EnvironmentLight { map: Arc::new(make_environment("black").unwrap()), rotation_deg: 0.0, scale: 1.0 };
    let scene = Scene::of_model(&model, Arc::default(), Arc::default(), light, model.unit_mm);
    let frame = Frame { width: 16, height: 16, relmse: 1e-12, ..Frame::default() };
    let (shape, environment) = (Some("sphere".to_owned()), Some("black".to_owned()));
    let stage = Stage { scene, shape, backdrop: None, environment, has_unit: true };
    let (mut slow, quick) = (Material::named("slow"), Material::named("quick"));
    slow.set(Property::emission, Value::Float(1.0));
    let text = |material: &Material| MaterialFile::new(material).text().to_owned();
    (entries(root, &[("a", text(&slow)), ("b", text(&quick))]), Arc::new(Setup::new(stage, frame, Vec::new())))
}

/// The thread's work, to be done step by step.
fn thread(root: &Path, entries: &[Arc<Entry>], slices: Slices) -> PictureThread {
    PictureThread {
        renderer: Renderer::new(root),
        shelf: None,
        queue: Arc::default(),
        may_make: Arc::new(Mutex::new(entries.iter().map(|entry| entry.look).collect())),
        threads: Arc::new(AtomicUsize::new(1)),
        made: HashSet::new(),
        slices,
        sender: channel().0,
        wake: Arc::new(|| {}),
    }
}

#[test]
fn a_slow_picture_does_not_hold_up_others_and_keeps_its_samples() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("library");
    let (entries, setup) = slow_and_quick(&root);
    // In no time at all, what is taken up keeps its samples, and what begins anew gets none.
    let mut thread = thread(&root, &entries, Slices::new([1.0, 0.0, 2.0], slices::MAX_BYTES));
    let order = |entry: &Arc<Entry>, purpose| Order { entry: entry.clone(), setup: setup.clone(), purpose };
    let in_sight = entries.iter().map(|entry| order(entry, Purpose::Sight));
    thread.queue.set(in_sight.chain([order(&entries[0], Purpose::Batch)]).collect());
    let (mut done, mut aside) = (Vec::new(), Vec::new());
    while done.len() < 2 {
        let due = thread.queue.next_by(|order| thread.slices.rank(order)).unwrap();
        match thread.make(&due.order).unwrap() {
            Outcome::PutAside => {
                assert_eq!(due.order.entry.path, Path::new("a.asm.ron"));
                aside.push((done.len(), thread.slices.spp(due.order.key())));
                thread.queue.again(due);
            }
            Outcome::Done(Done::Made(new)) => done.push((new.path.clone(), new.is_limited)),
            _ => panic!("both are wanted"),
        }
    }
    assert_eq!(done, [(PathBuf::from("b.asm.ron"), false), (PathBuf::from("a.asm.ron"), true)]);
    let [(0, Some(first)), (1, Some(second))] = aside[..] else { panic!("{aside:?}") };
    assert!(0 < first && first == second, "{first} {second}");
    assert_eq!(thread.slices.bytes(), 0, "what is done is forgotten");
    // The same picture of the batch is there already.
    let due = thread.queue.next_by(|order| thread.slices.rank(order)).unwrap();
    assert!(due.order.purpose == Purpose::Batch && matches!(thread.make(&due.order), Ok(Outcome::Unwanted)));
}

#[test]
fn what_is_scrolled_away_keeps_its_samples_until_they_are_in_the_way() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("library");
    let (entries, setup) = slow_and_quick(&root);
    let mut renderer = Renderer::new(&root);
    let limits = Limits { seconds: 60.0, threads: 1 };
    let mut begin = |entry: usize, begun: Option<Kept>| {
        let spp = begun.as_ref().map_or(0, Kept::spp);
        // Given up after a pass.
        renderer.render(&setup, &entries[entry], begun, limits, &mut |progress| progress.film.spp() <= spp).unwrap().0
    };
    let order = |entry: usize, purpose| Order { entry: entries[entry].clone(), setup: setup.clone(), purpose };
    let [slow, quick] = [0, 1].map(|entry| order(entry, Purpose::Sight));
    let rendering = begin(0, None);
    let size = rendering.keep().len();
    // Room for one.
    let mut slices = Slices::new([5.0, 20.0, 120.0], size + size / 2);
    assert_eq!((slices.limit(slow.key()), slices.take_up(slow.key()).is_none()), ((5.0, false), true));
    slices.put_aside(slow.key(), &rendering, false, |_| true);
    assert_eq!((slices.limit(slow.key()), slices.bytes()), ((5.0, false), size), "no slice of it is over");
    // It goes on from there.
    let begun = slices.take_up(slow.key());
    assert_eq!((begun.as_ref().map(Kept::spp), slices.bytes()), (Some(rendering.film.spp()), 0));
    let further = begin(0, begun);
    assert!(further.film.spp() > rendering.film.spp());
    slices.put_aside(slow.key(), &further, true, |_| true);
    assert_eq!(slices.limit(slow.key()), (20.0, false));
    // The second finds no room while the first is wanted, and takes it then.
    let other = begin(1, None);
    slices.put_aside(quick.key(), &other, true, |_| true);
    assert_eq!((slices.spp(slow.key()), slices.spp(quick.key())), (Some(further.film.spp()), None));
    slices.put_aside(quick.key(), &other, true, |look| look == quick.entry.look);
    assert_eq!((slices.spp(slow.key()), slices.spp(quick.key())), (None, Some(other.film.spp())));
    assert_eq!((slices.limit(slow.key()), slices.limit(quick.key())), ((20.0, false), (120.0, true)), "slices are not forgotten");
}

#[test]
fn pictures_come_by_slices_and_then_by_what_they_cost() {
    let folder = tempfile::tempdir().unwrap();
    let (entries, setup) = slow_and_quick(&folder.path().join("library"));
    let order = |entry: usize, purpose| Order { entry: entries[entry].clone(), setup: setup.clone(), purpose };
    let mut slices = Slices::new([5.0, 20.0, 120.0], 0);
    let sight = [0, 1].map(|entry| order(entry, Purpose::Sight));
    let rank = |slices: &Slices| [slices.rank(&sight[0]), slices.rank(&sight[1])];
    assert_eq!(rank(&slices)[0], rank(&slices)[1], "nothing is known");
    slices.expect(entries[0].look, 1.0, None);
    slices.expect(entries[1].look, 0.5, Some(0.01));
    let [slow, quick] = rank(&slices);
    assert!(quick < slow);
    let ends = [slices.rank(&order(0, Purpose::Draft)), slices.rank(&order(1, Purpose::Batch))];
    assert!(ends[0] < quick && slow < ends[1]);
    // The quick one has had its first slice: the slow one comes before its second.
    let (mut last, limits) = (None, Limits { seconds: 60.0, threads: 1 });
    let rendering =
        setup.expose(&setup.scene_of(Material::default(), Default::default()), &mut last, None, limits, &mut |_| false);
    for _ in 0..5 {
        slices.put_aside(sight[1].key(), &rendering, true, |_| true);
        let [slow, quick] = rank(&slices);
        assert!(slow < quick && quick < ends[1]);
    }
    slices.done(sight[1].key());
    let [slow, quick] = rank(&slices);
    assert!(quick < slow);
}
