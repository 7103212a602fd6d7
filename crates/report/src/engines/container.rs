//! The GLB container of a bake, taken apart and put together.

use serde_json::Value;

/// The elements of an array under `key`; none where there is no such array.
pub(super) fn list<'a>(json: &'a Value, key: &str) -> &'a [Value] {
    json[key].as_array().map_or(&[], Vec::as_slice)
}

/// JSON and BIN chunk of a GLB.
pub(crate) fn parts(glb: &[u8]) -> Option<(Value, Vec<u8>)> {
    let number =
        |at: usize| Some(u32::from_le_bytes(glb.get(at..at + 4)?.try_into().ok()?) as usize);
    let text_end = 20usize.checked_add(number(12)?)?;
    if !glb.starts_with(b"glTF") || glb.get(16..20)? != b"JSON" {
        return None;
    }
    let json = serde_json::from_slice(glb.get(20..text_end)?).ok()?;
    let end = (text_end + 8).checked_add(number(text_end)?)?;
    Some((json, glb.get(text_end + 8..end)?.to_vec()))
}

/// The container again; `None` past the format's 4 GiB.
pub(crate) fn whole(json: &mut Value, bin: &[u8]) -> Option<Vec<u8>> {
    json["buffers"][0]["byteLength"] = bin.len().into();
    let mut text = serde_json::to_vec(json).ok()?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = u32::try_from(28 + text.len() + bin.len()).ok()?;
    let mut file = b"glTF".to_vec();
    file.extend(
        [2, total, text.len() as u32]
            .iter()
            .flat_map(|n| n.to_le_bytes()),
    );
    file.extend(b"JSON");
    file.extend(text);
    file.extend((bin.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(bin);
    Some(file)
}
