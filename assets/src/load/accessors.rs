//! The numbers in a glTF document's buffers. Every offset and count is checked against the bytes that are there.

use std::path::Path;

use gltf::json::Root;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;

use super::uri::{self, Location};
use super::{AssetError, read_file};

/// Reads accessors, and buffers when they are first needed.
pub(super) struct Accessors<'a> {
    file: &'a Path,
    root: &'a Root,
    blob: Option<&'a [u8]>,
    /// One per buffer of the document, once it was needed.
    buffers: Vec<Option<Vec<u8>>>,
}

/// Where the elements of an accessor lie.
struct Elements<'b> {
    bytes: &'b [u8],
    stride: usize,
    count: usize,
    component: ComponentType,
    is_normalized: bool,
}

impl<'a> Accessors<'a> {
    pub(super) fn new(file: &'a Path, root: &'a Root, blob: Option<&'a [u8]>) -> Self {
        Self { file, root, blob, buffers: vec![None; root.buffers.len()] }
    }

    /// The vectors of `N` components in accessor `number`, as floats; normalized integers become -1 to 1 or 0 to 1.
    ///
    /// `place` is for messages.
    pub(super) fn floats<const N: usize>(&mut self, number: usize, place: &str) -> Result<Vec<[f32; N]>, AssetError> {
        let expected = match N {
            2 => Type::Vec2,
            3 => Type::Vec3,
            4 => Type::Vec4,
            _ => Type::Scalar,
        };
        let elements = self.elements(number, expected, N, place)?;
        let size = size_of(elements.component);
        let read = component_reader(elements.component, elements.is_normalized);
        let vectors = (0..elements.count).map(|k| {
            let begin = k * elements.stride;
            std::array::from_fn(|c| read(&elements.bytes[begin + c * size..]))
        });
        Ok(vectors.collect())
    }

    /// The whole numbers in accessor `number`.
    pub(super) fn indices(&mut self, number: usize, place: &str) -> Result<Vec<u32>, AssetError> {
        let file = self.file;
        let elements = self.elements(number, Type::Scalar, 1, place)?;
        let at = |k: usize| &elements.bytes[k * elements.stride..];
        let numbers = 0..elements.count;
        match elements.component {
            ComponentType::U8 => Ok(numbers.map(|k| u32::from(at(k)[0])).collect()),
            ComponentType::U16 => Ok(numbers.map(|k| u32::from(u16::from_le_bytes([at(k)[0], at(k)[1]]))).collect()),
            ComponentType::U32 => Ok(numbers.map(|k| first_word(at(k))).collect()),
            _ => Err(AssetError::malformed(file, place, "expected unsigned integers, found another component type")),
        }
    }

    /// Checks accessor `number`, so that each of its elements, of `components` components, can be read.
    fn elements(&mut self, number: usize, expected: Type, components: usize, place: &str) -> Result<Elements<'_>, AssetError> {
        let place = format!("{place} (accessor {number})");
        let malformed = |problem: String| AssetError::malformed(self.file, &*place, problem);
        let Some(accessor) = self.root.accessors.get(number) else {
            return Err(malformed(format!("expected a number below {}", self.root.accessors.len())));
        };
        if accessor.sparse.is_some() {
            let problem = "sparse accessors are not supported; expected a file exported with plain ones";
            return Err(AssetError::unsupported(self.file, place, problem));
        }
        let (Checked::Valid(component), Checked::Valid(kind)) = (&accessor.component_type, &accessor.type_) else {
            return Err(malformed("expected a known type and componentType".to_owned()));
        };
        if *kind != expected {
            return Err(malformed(format!("expected the type {expected:?}, found {kind:?}")));
        }
        let component = component.0;
        let Some(view_number) = accessor.buffer_view else {
            let problem = "expected a bufferView; an accessor of zeros or compressed data is not supported";
            return Err(AssetError::unsupported(self.file, place, problem));
        };
        let Some(view) = self.root.buffer_views.get(view_number.value()) else {
            return Err(malformed(format!("expected a bufferView below {}", self.root.buffer_views.len())));
        };
        let count = accessor.count.0;
        let element = (components * size_of(component)) as u64;
        let stride = view.byte_stride.as_ref().map_or(0, |stride| stride.0 as u64);
        let stride = if stride == 0 { element } else { stride };
        if stride < element {
            return Err(malformed(format!("expected a byteStride of at least {element}, found {stride}")));
        }

        // All in 64 bits with checks: each number comes from the file.
        let offset = accessor.byte_offset.unwrap_or_default().0;
        let view_offset = view.byte_offset.unwrap_or_default().0;
        let view_length = view.byte_length.0;
        let needed = count.checked_sub(1).map_or(Some(0), |gaps| gaps.checked_mul(stride)?.checked_add(element));
        let fits = needed.and_then(|needed| needed.checked_add(offset)).is_some_and(|end| end <= view_length);
        if !fits {
            let problem = format!(
                "expected {count} elements of {element} bytes with a stride of {stride} from byte {offset}, found a bufferView of {view_length} bytes"
            );
            return Err(malformed(problem));
        }
        let buffer_number = view.buffer.value();
        self.load_buffer(buffer_number, &place)?;
        let buffer = match self.buffers.get(buffer_number) {
            Some(Some(buffer)) => buffer.as_slice(),
            _ => self.blob.unwrap_or_default(),
        };
        let begin = view_offset.saturating_add(offset);
        let end = begin.saturating_add(needed.unwrap_or(u64::MAX));
        let range = usize::try_from(begin).ok().zip(usize::try_from(end).ok());
        let Some(bytes) = range.and_then(|(begin, end)| buffer.get(begin..end)) else {
            let problem = format!("expected {end} bytes in buffer {buffer_number}, found {}", buffer.len());
            return Err(AssetError::truncated(self.file, place, problem));
        };
        Ok(Elements {
            bytes,
            stride: stride as usize,
            // It fits: each element takes at least a byte of what is there.
            count: count as usize,
            component,
            is_normalized: accessor.normalized,
        })
    }

    /// Makes buffer `number` available, from where its URI points to. The GLB's own stays where it is.
    fn load_buffer(&mut self, number: usize, place: &str) -> Result<(), AssetError> {
        let Some(buffer) = self.root.buffers.get(number) else {
            let problem = format!("expected a buffer below {}, found {number}", self.root.buffers.len());
            return Err(AssetError::malformed(self.file, place, problem));
        };
        if self.buffers[number].is_some() {
            return Ok(());
        }
        let place = format!("buffer {number}");
        let Some(text) = &buffer.uri else {
            if number == 0 && self.blob.is_some() {
                return Ok(());
            }
            return Err(AssetError::missing(self.file, place, "expected a uri or the binary chunk of a GLB, found neither"));
        };
        let bytes = match uri::locate(text) {
            Ok(Location::Inline(bytes)) => bytes,
            Ok(Location::Relative(path)) => {
                let folder = self.file.parent().unwrap_or(Path::new(""));
                read_file(&folder.join(&path)).map_err(|problem| {
                    AssetError::missing(self.file, &*place, format!("cannot read its data: {}", without_stop(&problem)))
                })?
            }
            Err(problem) => return Err(AssetError::malformed(self.file, format!("{place}, uri"), problem)),
        };
        if (bytes.len() as u64) < buffer.byte_length.0 {
            let problem = format!("expected {} bytes, found {}", buffer.byte_length.0, bytes.len());
            return Err(AssetError::truncated(self.file, place, problem));
        }
        self.buffers[number] = Some(bytes);
        Ok(())
    }
}

/// A message to go into another sentence.
fn without_stop(problem: &AssetError) -> String {
    problem.to_string().trim_end_matches('.').to_owned()
}

fn size_of(component: ComponentType) -> usize {
    match component {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    }
}

fn first_word(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

/// Reads one component from the start of a slice that is long enough.
fn component_reader(component: ComponentType, is_normalized: bool) -> fn(&[u8]) -> f32 {
    match (component, is_normalized) {
        (ComponentType::I8, true) => |b| (f32::from(b[0] as i8) / 127.0).max(-1.0),
        (ComponentType::I8, false) => |b| f32::from(b[0] as i8),
        (ComponentType::U8, true) => |b| f32::from(b[0]) / 255.0,
        (ComponentType::U8, false) => |b| f32::from(b[0]),
        (ComponentType::I16, true) => |b| (f32::from(i16::from_le_bytes([b[0], b[1]])) / 32767.0).max(-1.0),
        (ComponentType::I16, false) => |b| f32::from(i16::from_le_bytes([b[0], b[1]])),
        (ComponentType::U16, true) => |b| f32::from(u16::from_le_bytes([b[0], b[1]])) / 65535.0,
        (ComponentType::U16, false) => |b| f32::from(u16::from_le_bytes([b[0], b[1]])),
        (ComponentType::U32, _) => |b| first_word(b) as f32,
        (ComponentType::F32, _) => |b| f32::from_bits(first_word(b)),
    }
}
