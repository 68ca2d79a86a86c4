// The search of the site where there is no server: a page that is opened as a file may not start the worker that searches otherwise.

if (location.protocol === "file:") document.addEventListener("DOMContentLoaded", () => {
  const { base } = JSON.parse(document.getElementById("__config").textContent);
  const input = document.querySelector(".md-search__input"), list = document.querySelector(".md-search-result__list");
  const meta = document.querySelector(".md-search-result__meta"), mostShown = 30;
  const plain = (html) => new DOMParser().parseFromString(html, "text/html").body.textContent;
  let entries = null;

  // The theme hides its search when its own fails.
  const search = document.querySelector(".md-search"), reveal = () => { if (search.hidden) search.hidden = false; };
  new MutationObserver(reveal).observe(search, { attributes: true, attributeFilter: ["hidden"] });
  reveal();

  /** Entries that have all words, those that have them in the title first. */
  const found = (words) => {
    const rank = ({ title, all }) => words.reduce((sum, word) => sum + (title.includes(word) ? 10 : 0) + (all.split(word).length > 3), 0);
    return entries.filter(({ all }) => words.every((word) => all.includes(word)))
      .map((entry) => ({ entry, rank: rank(entry) })).sort((a, b) => b.rank - a.rank).map(({ entry }) => entry);
  };

  const around = (text, word) => {
    const at = Math.max(0, text.toLowerCase().indexOf(word) - 60);
    return (at ? "… " : "") + text.slice(at, at + 200).trim() + " …";
  };

  const show = () => {
    const words = input.value.toLowerCase().split(/\s+/).filter((word) => word.length > 1);
    const all = words.length && entries ? found(words) : [];
    meta.textContent = !words.length ? "Type to start searching" : entries ? all.length + " found" : "Loading";
    list.replaceChildren(...all.slice(0, mostShown).map(({ doc, text }) => {
      const link = document.createElement("a"), title = document.createElement("h1"), excerpt = document.createElement("p");
      [title.textContent, excerpt.textContent] = [plain(doc.title), around(text, words[0])];
      [title.className, excerpt.className] = ["md-search-result__title", "md-search-result__teaser"];
      Object.assign(link, { href: base + "/" + doc.location, className: "md-search-result__link" });
      const article = document.createElement("article"), item = document.createElement("li");
      article.className = "md-search-result__article";
      item.className = "md-search-result__item";
      article.append(title, excerpt);
      link.append(article);
      item.append(link);
      return item;
    }));
  };

  const index = document.createElement("script");  // scripts may be loaded from files, data may not
  index.src = base + "/search/search_index.js";
  index.onload = () => {
    entries = window.searchIndex.docs.map((doc) => {
      const text = plain(doc.text);
      return { doc, text, title: doc.title.toLowerCase(), all: (doc.title + " " + text).toLowerCase() };
    });
    show();
  };
  document.head.append(index);
  input.addEventListener("input", show);
});
