//! What was gathered: in memory, and in a journal from which an interrupted job goes on.
//!
//! A block of the journal is a tag (u32) and what follows it. Probes: of each its number and its numbers (f64). A face
//! of a reflection map: its number (u32) and its pixels (f32). All are little-endian.

use crate::error::Error;
use crate::resume::{END, PERIOD, SHARE, opened};
use ::probes::Placed;
use glam::DVec3;
use report::{Journal, Output};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

const PROBES: u32 = 0;
const FACE: u32 = 1;

/// What waits for the disk at most, in bytes.
const WAITING: usize = 16 << 20;

/// Pixels of a face.
pub(super) type Face = Vec<[f32; 3]>;

/// What was gathered until now.
pub(super) struct Kept<'a> {
    asked: &'a [DVec3],
    /// Order of the harmonics.
    order: usize,
    /// Texels of a face, and how many faces there are.
    texels: usize,
    faces: u32,
    /// By number.
    pub placed: Vec<Option<Placed>>,
    /// The journal and the block of each face that is on the disk.
    found: BTreeMap<u32, (usize, usize)>,
    journals: Vec<Journal>,
    state: Option<State>,
}

/// A file that grows.
struct State {
    path: PathBuf,
    header: Value,
    /// Probes that wait, and faces, each a block.
    probes: Vec<u8>,
    blocks: Vec<Vec<u8>>,
    /// When the file was written last, and how long that took.
    written: (Instant, Duration),
    /// The folder, which goes again where nothing comes into it.
    _output: Output,
}

impl<'a> Kept<'a> {
    /// Nothing, for these places and so many faces of so many texels.
    pub fn new(asked: &'a [DVec3], order: usize, faces: u32, texels: usize) -> Self {
        Self {
            asked,
            order,
            texels,
            faces,
            placed: vec![None; asked.len()],
            found: BTreeMap::new(),
            journals: Vec::new(),
            state: None,
        }
    }

    /// Keeps what comes in a file, which is made when the first of it is written.
    pub fn save(&mut self, output: Output, path: PathBuf, header: Value) {
        self.state = Some(State {
            path,
            header,
            probes: PROBES.to_le_bytes().to_vec(),
            blocks: Vec::new(),
            written: (Instant::now(), Duration::ZERO),
            _output: output,
        });
    }

    /// Opens that file now and takes what it holds, where it is of the same job; what there is to say of it, in a line.
    ///
    /// # Errors
    /// The file cannot be written, or another run writes it.
    pub fn resume(&mut self) -> Result<Option<String>, Error> {
        let Some(State { path, header, .. }) = &self.state else {
            return Ok(None);
        };
        let (path, header) = (path.clone(), header.clone());
        let (journal, damage, other) = opened(&path, &header)?;
        let is_empty = journal.is_empty();
        let fits = self.add(journal)?;
        if !fits {
            self.journals.clear();
            self.found.clear();
            self.placed.fill(None);
            let (journal, _) = Journal::resume(&path, &header, |_| false)?;
            self.journals.push(journal);
        }
        let path = path.display();
        Ok(match (damage, other) {
            (Some(damage), _) => Some(format!("{damage}; starting over")),
            (None, Some(differs)) => Some(format!(
                "what was saved in {path} is of other probes, {differs} differs; starting over"
            )),
            _ if !fits => Some(format!(
                "cannot read {path}: the file is damaged; starting over"
            )),
            _ if is_empty => None,
            _ => Some(format!("going on from what was saved in {path}")),
        })
    }

    /// Takes what a journal holds; false where it is of something else.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn add(&mut self, mut journal: Journal) -> Result<bool, Error> {
        let number = self.journals.len();
        let mut fits = true;
        for block in 0..journal.len() {
            let bytes = journal.block(block)?;
            fits &= self.take(&bytes, (number, block)).is_some();
        }
        self.journals.push(journal);
        Ok(fits)
    }

    fn take(&mut self, bytes: &[u8], from: (usize, usize)) -> Option<()> {
        let (tag, rest) = bytes.split_first_chunk()?;
        match u32::from_le_bytes(*tag) {
            PROBES => {
                let numbers: Vec<f64> = (rest.as_chunks::<8>().0.iter())
                    .map(|b| f64::from_le_bytes(*b))
                    .collect();
                for numbers in numbers.chunks(1 + Placed::length(self.order)) {
                    let (number, numbers) = numbers.split_first()?;
                    let number = *number as usize;
                    let asked = *self.asked.get(number)?;
                    self.placed[number] = Some(Placed::of_numbers(numbers, self.order, asked)?);
                }
            }
            FACE => {
                let (number, pixels) = rest.split_first_chunk()?;
                let number = u32::from_le_bytes(*number);
                if number >= self.faces || pixels.len() != 12 * self.texels {
                    return None;
                }
                self.found.insert(number, from);
            }
            // A part that was killed between its last block and its name.
            END => {}
            _ => return None,
        }
        Some(())
    }

    /// True where a face is on the disk.
    pub fn has_face(&self, number: u32) -> bool {
        self.found.contains_key(&number)
    }

    /// A face that is on the disk.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn face(&mut self, number: u32) -> Result<Option<Face>, Error> {
        let Some(&(journal, block)) = self.found.get(&number) else {
            return Ok(None);
        };
        let bytes = self.journals[journal].block(block)?;
        let values = bytes[8..].as_chunks::<4>().0.iter();
        let values: Vec<f32> = values.map(|b| f32::from_le_bytes(*b)).collect();
        Ok(Some(values.as_chunks::<3>().0.to_vec()))
    }

    /// Takes a probe, and brings what waits to the disk when it is time.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn probe(&mut self, number: u32, placed: Placed) -> Result<(), Error> {
        if let Some(state) = &mut self.state {
            let numbers = [vec![f64::from(number)], placed.numbers()].concat();
            state
                .probes
                .extend(numbers.iter().flat_map(|v| v.to_le_bytes()));
        }
        self.placed[number as usize] = Some(placed);
        self.flush_in_time()
    }

    /// Brings a face to the disk when it is time. It is not kept in memory.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn keep_face(&mut self, number: u32, pixels: &[[f32; 3]]) -> Result<(), Error> {
        if let Some(state) = &mut self.state {
            let mut block = [FACE, number].map(u32::to_le_bytes).concat();
            block.extend(pixels.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
            state.blocks.push(block);
        }
        self.flush_in_time()
    }

    fn flush_in_time(&mut self) -> Result<(), Error> {
        let is_time = |state: &State| {
            let bytes = state.probes.len() + state.blocks.iter().map(Vec::len).sum::<usize>();
            let (last, cost) = state.written;
            last.elapsed() >= PERIOD.max(cost * SHARE) || bytes > WAITING
        };
        match self.state.as_ref().is_some_and(is_time) {
            true => self.flush(),
            false => Ok(()),
        }
    }

    /// Brings everything that waits to the disk.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn flush(&mut self) -> Result<(), Error> {
        let Some(state) = &mut self.state else {
            return Ok(());
        };
        let started = Instant::now();
        let tag = PROBES.to_le_bytes().to_vec();
        if state.probes.len() > tag.len() {
            let probes = std::mem::replace(&mut state.probes, tag);
            state.blocks.push(probes);
        }
        if state.blocks.is_empty() {
            return Ok(());
        }
        if self.journals.is_empty() {
            let (journal, _) = Journal::resume(&state.path, &state.header, |_| false)?;
            self.journals.push(journal);
        }
        for block in state.blocks.drain(..) {
            self.journals[0].append(&block)?;
        }
        state.written = (Instant::now(), started.elapsed());
        Ok(())
    }

    /// Brings everything to the disk with a last block, and gives the file its final name.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn end(&mut self, path: &std::path::Path) -> Result<(), Error> {
        self.flush()?;
        if let Some(state) = &mut self.state {
            state.blocks.push(END.to_le_bytes().to_vec());
        }
        self.flush()?;
        if let Some(journal) = self.journals.first_mut() {
            journal.rename(path)?;
        }
        Ok(())
    }
}
