//! The sheet as a page: pictures inside it, a box that filters, fit for printing.

use super::{Card, MAX_CARDS, Sheet, SheetError};
use crate::html::{data_uri, escape, page};
use crate::picture_job::PROGRAM;
use image::codecs::jpeg::JpegEncoder;

const STYLE: &str = include_str!("sheet.css");
const SCRIPT: &str = include_str!("sheet.js");
/// Quality of the pictures as JPEG, of 100.
const QUALITY: u8 = 88;

impl Sheet {
    /// An error if there are more materials than a page can hold.
    pub(super) fn refuse_too_long(&self) -> Result<(), SheetError> {
        let (count, most) = (self.cards.len(), || format!("at most {MAX_CARDS} in a page; a search narrows them down"));
        if count > MAX_CARDS { Err(SheetError::TooMany { count, most: most() }) } else { Ok(()) }
    }

    /// The sheet as a page. `go_on` as for [`Sheet::bytes`].
    pub fn html(&self, go_on: &mut dyn FnMut(usize) -> bool) -> Result<Option<String>, SheetError> {
        self.refuse_too_long()?;
        // Sharp on fine screens as long as that does not make the page slow.
        let side = self.side.unwrap_or(if self.cards.len() <= 1000 { 512 } else { 160 }).max(1);
        let mut body = format!(
            "<header>\n<div><h1 dir=\"auto\">{}</h1><p>{} · {}</p></div>\n<label hidden>Filter <input type=\"search\" id=\"filter\" \
             placeholder=\"name, group, tag, licence\" autocomplete=\"off\" spellcheck=\"false\"> <output for=\"filter\"></output></label>\n</header>\n<main>\n",
            escape(&self.title),
            self.facts(),
            escape(PROGRAM)
        );
        let mut done = 0;
        for cards in self.groups() {
            let group = cards.first().map_or("", |card| card.group.as_str());
            let title = match group {
                "" => String::new(),
                group => format!("<h2><span dir=\"auto\">{}</span> <small>{}</small></h2>\n", escape(group), cards.len()),
            };
            body += &format!("<section>\n{title}<ul>\n");
            for card in cards {
                body += &item(card, side)?;
                done += 1;
                if !go_on(done) {
                    return Ok(None);
                }
            }
            body += "</ul>\n</section>\n";
        }
        body += &format!("</main>\n<p id=\"none\" hidden>Nothing matches.</p>\n<script>\n{SCRIPT}</script>\n");
        Ok(Some(page(&self.title, STYLE, &body)))
    }
}

/// One material.
fn item(card: &Card, side: u32) -> Result<String, SheetError> {
    let name = escape(&card.name);
    let picture = match card.small_picture(side) {
        Some(picture) => {
            let mut bytes = Vec::new();
            picture
                .write_with_encoder(JpegEncoder::new_with_quality(&mut bytes, QUALITY))
                .map_err(|error| SheetError::Encode(error.to_string()))?;
            let (width, height) = picture.dimensions();
            let uri = data_uri("image/jpeg", &bytes);
            format!("<img alt=\"{name}\" width=\"{width}\" height=\"{height}\" decoding=\"async\" src=\"{uri}\">")
        }
        None => "<div class=\"none\">no picture</div>".to_owned(),
    };
    let stale = if card.is_stale { "<p class=\"stale\">picture of an earlier state</p>" } else { "" };
    let line = |class: &str, text: &str| {
        if text.is_empty() { String::new() } else { format!("<p class=\"{class}\" dir=\"auto\">{}</p>", escape(text)) }
    };
    let provenance = &card.provenance;
    let licence = match provenance.licence.trim() {
        "" => "<p class=\"licence stale\">no licence stated</p>".to_owned(),
        licence => line("licence", licence),
    };
    let hash = card.hash.to_string();
    let rows =
        [("Reference", provenance.reference.as_str()), ("Method", &provenance.method), ("File", &card.path), ("Hash", &hash)];
    let rows: String = rows
        .iter()
        .filter(|(_, text)| !text.trim().is_empty())
        .map(|(title, text)| format!("<dt>{title}</dt><dd dir=\"auto\">{}</dd>", escape(text)))
        .collect();
    Ok(format!(
        "<li>{picture}<h3 dir=\"auto\">{name}</h3>{stale}{}{licence}{}<details><summary>Origin</summary><dl>{rows}</dl></details></li>\n",
        line("tags", &card.tags.join(", ")),
        line("source", &provenance.source)
    ))
}
