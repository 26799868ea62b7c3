"""What `import webloop` offers, with its types. Where a plant has two inputs u is a tuple of two, and
where it has two outputs y is one."""

from webloop import results as results
from webloop.own import Controller as Controller
from webloop.own import control as control
from webloop.own_plant import Plant as Plant
from webloop.own_plant import plant as plant
