// Pages that explain come before those with all measurements.
var Scorer = {
  score: result => result[4] - (result[0].startsWith("docs/notes/") ? 20 : result[0] === "CHANGELOG" || result[0] === "docs/errors" ? 12 : 0),
  objNameMatch: 11, objPartialMatch: 6, objPrio: { 0: 15, 1: 5, 2: -5 }, objPrioDefault: 0, title: 15, partialTitle: 7, term: 5, partialTerm: 2
};
