"use strict";
// A click on a heading sorts the trials by that column; another turns the order round.
(() => {
  const body = document.querySelector("#trials tbody");
  const headings = [...document.querySelectorAll("#trials thead th")];
  const compare = {
    text: (a, b) => a.localeCompare(b, undefined, { numeric: true }),
    number: (a, b) => Number(a) - Number(b),
  };
  headings.forEach((heading, column) => {
    const button = heading.querySelector("button");
    button.addEventListener("click", () => {
      const upward = heading.getAttribute("aria-sort") !== "ascending";
      const value = (row) => row.children[column].dataset.value;
      const rows = [...body.rows].sort((a, b) => compare[button.dataset.kind](value(a), value(b)));
      body.append(...(upward ? rows : rows.reverse()));
      for (const other of headings) other.removeAttribute("aria-sort");
      heading.setAttribute("aria-sort", upward ? "ascending" : "descending");
    });
  });
})();
