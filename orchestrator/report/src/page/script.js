// What the page can do with a script: filter the claims, switch the colours, open what a link names, show
// which boxes have more to scroll to.
"use strict";
(() => {
  const root = document.documentElement;
  root.classList.add("script");

  // Colours: the system's until the button is pressed.
  const theme = document.getElementById("theme");
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : dark.matches);
  const show = () => {
    theme.setAttribute("aria-pressed", String(isDark()));
    root.dispatchEvent(new Event("colours"));
  };
  theme.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    show();
  });
  dark.addEventListener("change", show);
  show();

  // Claims by verdict.
  const claims = [...document.querySelectorAll("#board .claim")];
  const buttons = [...document.querySelectorAll("[data-show]")];
  for (const button of buttons) {
    button.addEventListener("click", () => {
      const verdict = button.dataset.show;
      let shown = 0;
      for (const claim of claims) {
        claim.hidden = verdict !== "" && claim.dataset.verdict !== verdict;
        shown += claim.hidden ? 0 : 1;
      }
      for (const other of buttons) {
        other.setAttribute("aria-pressed", String(other === button));
      }
      document.getElementById("shown").textContent = `${shown} of ${claims.length} claims shown`;
    });
  }

  // A link may name something inside what is folded.
  const unfold = () => {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!target) return;
    for (let at = target; at; at = at.parentElement) {
      if (at instanceof HTMLDetailsElement) at.open = true;
      if (at.hidden) at.hidden = false;
    }
    target.scrollIntoView();
  };
  addEventListener("hashchange", unfold);
  if (location.hash) unfold();

  // Where a box has more beside what it shows.
  const boxes = [...document.querySelectorAll(".scroll")];
  const edge = (box) => {
    const hidden = box.scrollWidth - box.clientWidth;
    box.classList.toggle("is-before", box.scrollLeft > 4);
    box.classList.toggle("is-behind", hidden - box.scrollLeft > 4);
  };
  const watch = new ResizeObserver((entries) => entries.forEach((entry) => edge(entry.target)));
  for (const box of boxes) {
    edge(box);
    box.addEventListener("scroll", () => edge(box), { passive: true });
    watch.observe(box);
  }

  // Where in the contents one is.
  const links = new Map(
    [...document.querySelectorAll(".contents li a")].map((link) => [link.hash.slice(1), link]),
  );
  const mark = (id) => {
    for (const [name, link] of links) {
      if (name === id) link.setAttribute("aria-current", "true");
      else link.removeAttribute("aria-current");
    }
  };
  const seen = new IntersectionObserver(
    (entries) => {
      for (const entry of entries) if (entry.isIntersecting) mark(entry.target.id);
    },
    { rootMargin: "-20% 0px -75% 0px" },
  );
  for (const section of document.querySelectorAll("main > section")) seen.observe(section);
})();
