// Makes every table sort by a click on a header. `?sort=TABLE.COLUMN` (from 0; `-`: largest first) sorts at once.
"use strict";
(function () {
  function keyOf(row, column) {
    const cell = row.cells[column];
    const key = cell.dataset.key;
    return key === undefined ? cell.textContent.trim() : Number(key);
  }
  // Numbers before words, and rows that are alike stay in their order.
  function compare(a, b) {
    if (typeof a === typeof b) return typeof a === "number" ? a - b : a.localeCompare(b);
    return typeof a === "number" ? -1 : 1;
  }
  function sort(table, column, descending) {
    const body = table.tBodies[0];
    const rows = Array.from(body.rows).map(function (row) { return { row: row, key: keyOf(row, column) }; });
    const isNumber = rows.some(function (entry) { return typeof entry.key === "number"; });
    rows.sort(function (a, b) {
      const words = isNumber && typeof a.key !== typeof b.key; // a dash stays below, whichever way
      return compare(a.key, b.key) * (descending && !words ? -1 : 1);
    });
    rows.forEach(function (entry) { body.appendChild(entry.row); });
    Array.from(table.tHead.rows[0].cells).forEach(function (header, i) {
      if (i === column) header.setAttribute("aria-sort", descending ? "descending" : "ascending");
      else header.removeAttribute("aria-sort");
    });
  }
  document.querySelectorAll("main table").forEach(function (table) {
    Array.from(table.tHead.rows[0].cells).forEach(function (header, column) {
      const button = document.createElement("button");
      button.type = "button";
      while (header.firstChild) button.appendChild(header.firstChild);
      header.appendChild(button);
      button.addEventListener("click", function () {
        sort(table, column, header.getAttribute("aria-sort") === "ascending");
      });
    });
  });
  // On paper nothing can be opened.
  addEventListener("beforeprint", function () {
    document.querySelectorAll("details").forEach(function (one) { one.open = true; });
  });
  const asked = new URLSearchParams(location.search).get("sort");
  const parts = asked ? asked.match(/^(.+)\.(-?)(\d+)$/) : null;
  const table = parts ? document.getElementById(parts[1]) : null;
  if (table && table.tHead && Number(parts[3]) < table.tHead.rows[0].cells.length)
    sort(table, Number(parts[3]), parts[2] === "-");
})();
