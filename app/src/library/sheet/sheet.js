const filter = document.getElementById("filter"), none = document.getElementById("none");
const groups = Array.from(document.querySelectorAll("section"), section => ({
    section,
    cards: Array.from(section.querySelectorAll("li"), card =>
        ({ card, text: `${section.querySelector("h2 span")?.textContent ?? ""} ${card.textContent}`.toLowerCase() })),
}));
const count = groups.reduce((sum, group) => sum + group.cards.length, 0);
function apply() {
    const words = filter.value.toLowerCase().split(/\s+/).filter(word => word);
    let shown = 0;
    for (const { section, cards } of groups) {
        let inGroup = 0;
        for (const { card, text } of cards) {
            card.hidden = !words.every(word => text.includes(word));
            inGroup += !card.hidden;
        }
        section.hidden = inGroup === 0;
        const small = section.querySelector("small");
        if (small) small.textContent = inGroup;
        shown += inGroup;
    }
    none.hidden = shown > 0;
    filter.parentElement.querySelector("output").textContent = words.length ? `${shown} of ${count}` : "";
}
filter.addEventListener("input", apply);
filter.parentElement.hidden = false;
apply();
