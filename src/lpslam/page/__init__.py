"""A page that shows a map and answers: one file that needs nothing else, or beside a server that is asked."""
